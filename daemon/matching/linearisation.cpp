// SPDX-License-Identifier: BSD-3-Clause
#include "matching/linearisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "matching/float_row.hpp"

namespace slam {
namespace {

constexpr std::size_t kRowsAtOnce = 8;  // looked up before the first is used: the reference is larger than the caches

struct PoseRow {
  FloatRow x, y, cosine, sine;
  explicit PoseRow(const Pose2& T)
      : x(rowOf(T.x)), y(rowOf(T.y)), cosine(rowOf(std::cos(T.theta))), sine(rowOf(std::sin(T.theta))) {}
};

struct Kernel {
  double gate;                                                 // [m]
  FloatRow gate_squared, inverse_scale_squared, near_squared;  // [m^2, 1/m^2, m^2]
  FloatRow often, grazing_observations, point_weight, same_face;

  Kernel(double gate_, double scale, const MatchConfig& config)
      : gate(gate_),
        gate_squared(rowOf(gate_ * gate_)),
        inverse_scale_squared(rowOf(1.0 / (scale * scale))),
        near_squared(rowOf(config.overlap_distance * config.overlap_distance)),
        often(rowOf(config.known_observations)),
        grazing_observations(rowOf(config.grazing_observations)),
        point_weight(rowOf(config.point_weight)),
        same_face(rowOf(config.same_face)) {}
};

/// Four points and their partners, about the scan's own pose in the reference's axes.
struct PartnerRow {
  FloatRow rx{}, ry{}, nx{}, ny{};              // [m] R p, and the normal in base
  std::array<const Surfel*, kLanes> surfels{};  // nullptr: none
};

/// What a match asks of four surfels.
struct SurfelRow {
  IntRow there;
  FloatRow x, y, nx, ny, normal_variance, observations;
  IntRow grazing;
};

SurfelRow surfelsOf(const PartnerRow& partners) {
  static const Surfel kNone;
  std::array<FloatRow, kLanes> lines, rest;  // x, y, nx, ny, and what is behind them
  SurfelRow row;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const Surfel& surfel = partners.surfels[i] == nullptr ? kNone : *partners.surfels[i];
    lines[i] = FloatRow{surfel.x, surfel.y, surfel.nx, surfel.ny};
    rest[i] = FloatRow{surfel.normal_variance, surfel.observations, 0.0F, 0.0F};
    row.there[i] = -static_cast<int>(partners.surfels[i] != nullptr);
    row.grazing[i] = -static_cast<int>(surfel.grazing);
  }
  transpose(lines[0], lines[1], lines[2], lines[3]);
  transpose(rest[0], rest[1], rest[2], rest[3]);
  row.x = lines[0], row.y = lines[1], row.nx = lines[2], row.ny = lines[3];
  row.normal_variance = rest[0], row.observations = rest[1];
  return row;
}

/// Four pairs. Where there is none, or it is refused, both weights are 0.
struct PairRow {
  IntRow valid;
  FloatRow line_weight, point_weight;  // of pairs with a line, and of those with a point
  FloatRow nx, ny;                     // of the line
  FloatRow rx, ry, dx, dy;             // [m] R p, and from the surfel to the point
  FloatRow across, squared;            // [m] from the line, and [m^2] residual
  FloatRow lever;                      // [m] n . R' p
  FloatRow observations, normal_variance;
};

/// Where along the beam a sliding point was hit says nothing: it is a line along it, give or take the lidar's place in
/// base.
void turnAlongBeam(IntRow sliding, PairRow& pair) {
  FloatRow inverse{};
  for (std::size_t i = 0; i < kLanes; ++i)
    inverse[i] = 1.0F / std::max(1e-3F, std::sqrt(pair.rx[i] * pair.rx[i] + pair.ry[i] * pair.ry[i]));
  pair.nx = choose(sliding, -pair.ry * inverse, pair.nx);
  pair.ny = choose(sliding, pair.rx * inverse, pair.ny);
}

PairRow pairOf(const PartnerRow& point, const SurfelRow& surfel, const PoseRow& T, const Kernel& kernel) {
  const FloatRow zero{}, one = rowOf(1.0);
  PairRow pair;
  pair.nx = surfel.nx, pair.ny = surfel.ny;
  pair.rx = point.rx, pair.ry = point.ry;
  pair.observations = surfel.observations;
  pair.normal_variance = surfel.normal_variance;
  pair.dx = T.x - surfel.x + pair.rx;
  pair.dy = T.y - surfel.y + pair.ry;
  pair.squared = pair.dx * pair.dx + pair.dy * pair.dy;
  const IntRow line = surfel.nx * surfel.nx + surfel.ny * surfel.ny > zero;
  const IntRow sliding = surfel.grazing & (surfel.observations < kernel.grazing_observations);
  if (any(sliding)) turnAlongBeam(sliding, pair);
  const IntRow has_normal = point.nx * point.nx + point.ny * point.ny > zero;
  const FloatRow facing =
      pair.nx * (T.cosine * point.nx - T.sine * point.ny) + pair.ny * (T.sine * point.nx + T.cosine * point.ny);
  const IntRow other_face = facing < kernel.same_face;
  pair.valid = surfel.there & (pair.squared <= kernel.gate_squared) & ~(line & has_normal & other_face);
  pair.across = pair.nx * pair.dx + pair.ny * pair.dy;
  pair.lever = pair.ny * pair.rx - pair.nx * pair.ry;
  const IntRow along_line = line | sliding;
  pair.squared = choose(along_line, pair.across * pair.across, pair.squared);
  const FloatRow share = choose(line & ~sliding, one, kernel.point_weight);
  const FloatRow weight =
      surfel.observations * share / ((one + surfel.observations) * (one + pair.squared * kernel.inverse_scale_squared));
  pair.line_weight = where(pair.valid & along_line, weight);
  pair.point_weight = where(pair.valid & ~along_line, weight);
  return pair;
}

/// Calls add(first point, pairs) for each row of the scan, and endBlock() after every kRowsAtOnce of them.
/// @return points in the reference's window
int forEachPairs(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, const Kernel& kernel,
                 auto& consumer) {
  const PoseRow pose(T);
  const double c = std::cos(T.theta), s = std::sin(T.theta);
  int covered = 0;
  for (std::size_t begin = 0; begin < points.size(); begin += kRowsAtOnce * kLanes) {
    const auto block = points.subspan(begin, std::min(kRowsAtOnce * kLanes, points.size() - begin));
    std::array<PartnerRow, kRowsAtOnce> partners;
    for (std::size_t i = 0; i < block.size(); ++i) {
      const ScanPoint& point = block[i];
      PartnerRow& row = partners[i / kLanes];
      const std::size_t lane = i % kLanes;
      const double rx = c * point.position.x() - s * point.position.y();
      const double ry = s * point.position.x() + c * point.position.y();
      row.rx[lane] = static_cast<float>(rx), row.ry[lane] = static_cast<float>(ry);
      row.nx[lane] = static_cast<float>(point.normal.x()), row.ny[lane] = static_cast<float>(point.normal.y());
      const Eigen::Vector2d p(T.x + rx, T.y + ry);
      if (!reference.covers(p)) continue;
      ++covered;
      row.surfels[lane] = reference.nearest(p, kernel.gate);
      __builtin_prefetch(row.surfels[lane]);
    }
    for (std::size_t i = 0; i < block.size(); i += kLanes) {
      const PartnerRow& row = partners[i / kLanes];
      consumer.add(begin + i, pairOf(row, surfelsOf(row), pose, kernel));
    }
    consumer.endBlock();
  }
  return covered;
}

double taken(FloatRow& row) { return sumOf(std::exchange(row, FloatRow{})); }

/// The upper half of a symmetric sum over (x, y, theta), in single precision: so of few pairs.
struct SymmetricRows {
  FloatRow xx{}, xy{}, xt{}, yy{}, yt{}, tt{};

  void moveTo(Eigen::Matrix3d& H) {
    H(0, 0) += taken(xx), H(0, 1) += taken(xy), H(0, 2) += taken(xt);
    H(1, 1) += taken(yy), H(1, 2) += taken(yt), H(2, 2) += taken(tt);
  }
};

/// Sums of w r r^T over rows r of three, with what else a linearisation counts: in single precision, so of few pairs.
class RowSums {
 public:
  explicit RowSums(const Kernel& kernel) : kernel_(kernel) {}

  void add(std::size_t /*first*/, const PairRow& pair) {
    const FloatRow w = pair.line_weight, nx = w * pair.nx, ny = w * pair.ny, lever = w * pair.lever, e = pair.across;
    information_.xx += nx * pair.nx, information_.xy += nx * pair.ny, information_.yy += ny * pair.ny;
    information_.xt += nx * pair.lever, information_.yt += ny * pair.lever, information_.tt += lever * pair.lever;
    gx_ += nx * e, gy_ += ny * e, gt_ += lever * e, ee_ += w * e * e;
    // [t, t . R' p] with t along the line, and the variance of the normal.
    const FloatRow along = pair.nx * pair.rx + pair.ny * pair.ry, v = w * pair.normal_variance;
    const FloatRow vx = v * pair.nx, vy = v * pair.ny;
    spurious_.xx += vy * pair.ny, spurious_.xy -= vy * pair.nx, spurious_.yy += vx * pair.nx;
    spurious_.xt -= vy * along, spurious_.yt += vx * along, spurious_.tt += v * along * along;
    if (any(pair.point_weight > FloatRow{})) addPoints(pair);
    weight_ += w + pair.point_weight;
    const IntRow agreeing = pair.valid & (pair.squared < kernel_.near_squared);
    agreeing_error_ += where(agreeing, pair.squared);
    observations_ += where(agreeing, pair.observations);
    pairs_ += pair.valid, agreeing_ += agreeing, known_ += agreeing & (pair.observations >= kernel_.often);
  }

  void endBlock() {
    NormalEquations& equations = sums_.equations;
    information_.moveTo(equations.H);
    spurious_.moveTo(equations.spurious);
    equations.g += Eigen::Vector3d(taken(gx_), taken(gy_), taken(gt_));
    equations.squared_error += taken(ee_);
    equations.weight += taken(weight_);
    sums_.agreeing_error += taken(agreeing_error_);
    sums_.observations += taken(observations_);
  }

  Linearisation of(int covered) {
    for (Eigen::Matrix3d* H : {&sums_.equations.H, &sums_.equations.spurious})
      *H = H->selfadjointView<Eigen::Upper>().toDenseMatrix();
    sums_.equations.pairs = countOf(pairs_);
    sums_.agreeing = countOf(agreeing_);
    sums_.known = countOf(known_);
    sums_.covered = covered;
    return sums_;
  }

 private:
  void addPoints(const PairRow& pair) {  // rows [1, 0, -ry] and [0, 1, rx]
    const FloatRow w = pair.point_weight, rx = w * pair.rx, ry = w * pair.ry, dx = w * pair.dx, dy = w * pair.dy;
    information_.xx += w, information_.yy += w, information_.xt -= ry, information_.yt += rx,
        information_.tt += rx * pair.rx + ry * pair.ry;
    gx_ += dx, gy_ += dy, gt_ += rx * pair.dy - ry * pair.dx, ee_ += w * pair.squared;
  }

  Kernel kernel_;
  SymmetricRows information_, spurious_;
  FloatRow gx_{}, gy_{}, gt_{}, ee_{};
  FloatRow weight_{}, agreeing_error_{}, observations_{};
  IntRow pairs_{}, agreeing_{}, known_{};
  Linearisation sums_;
};

/// Points in a row that one wall or body gives. @return whether point i begins another part than that of `first`
bool beginsPart(std::span<const ScanPoint> points, std::size_t first, std::size_t i, const MatchConfig& config) {
  if ((points[i].position - points[i - 1].position).squaredNorm() > config.part_gap * config.part_gap) return true;
  const bool lines = points[i].hasNormal() && points[first].hasNormal();
  return lines && points[i].normal.dot(points[first].normal) <= config.part_bend;
}

}  // namespace

Linearisation linearise(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                        double gate, double kernel_scale, const MatchConfig& config) {
  const Kernel kernel(gate, kernel_scale, config);
  RowSums sums(kernel);
  const int covered = forEachPairs(reference, points, T_ref_base, kernel, sums);
  return sums.of(covered);
}

Eigen::Matrix3d pullsOfParts(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T_ref_base,
                             const MatchConfig& config) {
  struct Parts {
    std::span<const ScanPoint> points;
    const MatchConfig& config;
    std::size_t first = 0;
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    Eigen::Matrix3d pulls = Eigen::Matrix3d::Zero();

    void end() { pulls += pull * pull.transpose(), pull.setZero(); }
    void add(std::size_t begin, const PairRow& pair) {
      const FloatRow line = pair.line_weight * pair.across, dx = pair.point_weight * pair.dx,
                     dy = pair.point_weight * pair.dy;
      const FloatRow x = line * pair.nx + dx, y = line * pair.ny + dy,
                     theta = line * pair.lever + pair.rx * dy - pair.ry * dx;
      for (std::size_t lane = 0, i = begin; lane < kLanes && i < points.size(); ++lane, ++i) {
        if (i > 0 && beginsPart(points, first, i, config)) end(), first = i;
        pull += Eigen::Vector3f(x[lane], y[lane], theta[lane]).cast<double>();
      }
    }
    void endBlock() {}
  } parts{points, config};
  forEachPairs(reference, points, T_ref_base, {config.final_pair_distance, config.kernel_scale, config}, parts);
  parts.end();
  return parts.pulls;
}

}  // namespace slam
