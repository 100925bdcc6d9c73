// SPDX-License-Identifier: BSD-3-Clause
#include "matching/linearisation.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
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
  std::array<FloatPair, kLanes> r, n;  // [m] R p, and the normal in base
  std::array<const Surfel*, kLanes> surfels;
};

/// What a match asks of four surfels.
struct SurfelRow {
  IntRow there;
  FloatRow x, y, nx, ny, normal_variance, observations;
  IntRow grazing;
};

[[gnu::always_inline]] inline SurfelRow surfelsOf(const PartnerRow& partners) {
  static_assert(offsetof(Surfel, ny) == 3 * sizeof(float) && offsetof(Surfel, normal_variance) == sizeof(FloatRow));
  static_assert(offsetof(Surfel, grazing) == 6 * sizeof(float) && sizeof(bool) == 1);
  const int first_byte = std::endian::native == std::endian::little ? 1 : 1 << 24;
  std::array<FloatRow, kLanes> lines, rest;  // x, y, nx, ny; and normal_variance, observations, grazing, a shift
  for (std::size_t i = 0; i < kLanes; ++i) {
    lines[i] = loadRow(*partners.surfels[i], offsetof(Surfel, x));
    rest[i] = loadRow(*partners.surfels[i], offsetof(Surfel, normal_variance));
  }
  transpose(lines[0], lines[1], lines[2], lines[3]);
  transpose(rest[0], rest[1], rest[2], rest[3]);
  return {.there = rest[1] > FloatRow{},
          .x = lines[0],
          .y = lines[1],
          .nx = lines[2],
          .ny = lines[3],
          .normal_variance = rest[0],
          .observations = rest[1],
          .grazing = (std::bit_cast<IntRow>(rest[2]) & first_byte) != 0};
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

[[gnu::always_inline]] inline PairRow pairOf(const PartnerRow& point, const SurfelRow& surfel, const PoseRow& T,
                                             const Kernel& kernel) {
  const FloatRow zero{}, one = rowOf(1.0);
  PairRow pair;
  pair.nx = surfel.nx, pair.ny = surfel.ny;
  pairsOf(point.r, pair.rx, pair.ry);
  FloatRow point_nx, point_ny;  // in base
  pairsOf(point.n, point_nx, point_ny);
  pair.observations = surfel.observations;
  pair.normal_variance = surfel.normal_variance;
  pair.dx = T.x - surfel.x + pair.rx;
  pair.dy = T.y - surfel.y + pair.ry;
  pair.squared = pair.dx * pair.dx + pair.dy * pair.dy;
  const IntRow line = surfel.nx * surfel.nx + surfel.ny * surfel.ny > zero;
  const IntRow sliding = surfel.grazing & (surfel.observations < kernel.grazing_observations);
  if (any(sliding)) turnAlongBeam(sliding, pair);
  const IntRow has_normal = point_nx * point_nx + point_ny * point_ny > zero;
  const FloatRow facing =
      pair.nx * (T.cosine * point_nx - T.sine * point_ny) + pair.ny * (T.sine * point_nx + T.cosine * point_ny);
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

/// Calls consume(first point, rows, pairs of row i) for every kRowsAtOnce rows of the scan.
/// @return points in the reference's window
int forEachPairs(const Reference& reference, std::span<const ScanPoint> points, const Pose2& T, const Kernel& kernel,
                 auto&& consume) {
  const PoseRow pose(T);
  const double c = std::cos(T.theta), s = std::sin(T.theta);
  const DoublePair x_axis{c, s}, y_axis{-s, c};
  static const Surfel kNone;  // which nobody has observed
  int covered = 0;
  for (std::size_t begin = 0; begin < points.size(); begin += kRowsAtOnce * kLanes) {
    const auto block = points.subspan(begin, std::min(kRowsAtOnce * kLanes, points.size() - begin));
    std::array<PartnerRow, kRowsAtOnce> partners;
    for (std::size_t i = 0; i < block.size(); i += kLanes) {
      PartnerRow& row = partners[i / kLanes];
      const std::size_t lanes = std::min(kLanes, block.size() - i);
      if (lanes < kLanes) row = {.r = {}, .n = {}, .surfels = {&kNone, &kNone, &kNone, &kNone}};
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const ScanPoint& point = block[i + lane];
        const DoublePair r = x_axis * point.position.x() + y_axis * point.position.y();
        row.r[lane] = singles(r);
        row.n[lane] = singles(DoublePair{point.normal.x(), point.normal.y()});
        const Eigen::Vector2d p(T.x + r[0], T.y + r[1]);
        const bool is_covered = reference.covers(p);
        covered += is_covered ? 1 : 0;
        const Surfel* surfel = is_covered ? reference.nearest(p, kernel.gate) : nullptr;
        row.surfels[lane] = surfel == nullptr ? &kNone : surfel;
        __builtin_prefetch(row.surfels[lane]);
      }
    }
    const std::size_t rows = (block.size() + kLanes - 1) / kLanes;
    consume(begin, rows, [&](std::size_t i) { return pairOf(partners[i], surfelsOf(partners[i]), pose, kernel); });
  }
  return covered;
}

/// The upper half of a symmetric sum over (x, y, theta), in single precision: so of few pairs.
struct SymmetricRows {
  FloatRow xx{}, xy{}, xt{}, yy{}, yt{}, tt{};

  void addTo(Eigen::Matrix3d& H) const {
    H(0, 0) += sumOf(xx), H(0, 1) += sumOf(xy), H(0, 2) += sumOf(xt);
    H(1, 1) += sumOf(yy), H(1, 2) += sumOf(yt), H(2, 2) += sumOf(tt);
  }
};

/// Sums of w r r^T over rows r of three, with what else a linearisation counts: in single precision, so of few pairs.
struct RowSums {
  SymmetricRows information, spurious;
  FloatRow gx{}, gy{}, gt{}, ee{};
  FloatRow weight{}, agreeing_error{};
  IntRow pairs{}, agreeing{}, known{};

  void add(const PairRow& pair, const Kernel& kernel) {
    const FloatRow w = pair.line_weight, nx = w * pair.nx, ny = w * pair.ny, lever = w * pair.lever, e = pair.across;
    information.xx += nx * pair.nx, information.xy += nx * pair.ny, information.yy += ny * pair.ny;
    information.xt += nx * pair.lever, information.yt += ny * pair.lever, information.tt += lever * pair.lever;
    gx += nx * e, gy += ny * e, gt += lever * e, ee += w * e * e;
    // [t, t . R' p] with t along the line, and the variance of the normal.
    const FloatRow along = pair.nx * pair.rx + pair.ny * pair.ry, v = w * pair.normal_variance;
    const FloatRow vx = v * pair.nx, vy = v * pair.ny;
    spurious.xx += vy * pair.ny, spurious.xy -= vy * pair.nx, spurious.yy += vx * pair.nx;
    spurious.xt -= vy * along, spurious.yt += vx * along, spurious.tt += v * along * along;
    if (any(pair.point_weight > FloatRow{})) addPoints(pair);
    weight += w + pair.point_weight;
    const IntRow agrees = pair.valid & (pair.squared < kernel.near_squared);
    agreeing_error += where(agrees, pair.squared);
    pairs += pair.valid, agreeing += agrees, known += agrees & (pair.observations >= kernel.often);
  }

  void addPoints(const PairRow& pair) {  // rows [1, 0, -ry] and [0, 1, rx]
    const FloatRow w = pair.point_weight, rx = w * pair.rx, ry = w * pair.ry, dx = w * pair.dx, dy = w * pair.dy;
    information.xx += w, information.yy += w, information.xt -= ry, information.yt += rx,
        information.tt += rx * pair.rx + ry * pair.ry;
    gx += dx, gy += dy, gt += rx * pair.dy - ry * pair.dx, ee += w * pair.squared;
  }

  void addTo(Linearisation& sums) const {
    NormalEquations& equations = sums.equations;
    information.addTo(equations.H);
    spurious.addTo(equations.spurious);
    equations.g += Eigen::Vector3d(sumOf(gx), sumOf(gy), sumOf(gt));
    equations.squared_error += sumOf(ee);
    equations.weight += sumOf(weight);
    equations.pairs += countOf(pairs);
    sums.agreeing_error += sumOf(agreeing_error);
    sums.agreeing += countOf(agreeing);
    sums.known += countOf(known);
  }
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
  Linearisation sums;
  sums.covered =
      forEachPairs(reference, points, T_ref_base, kernel, [&](std::size_t, std::size_t rows, auto&& pairsAt) {
        RowSums block;
        for (std::size_t i = 0; i < rows; ++i) block.add(pairsAt(i), kernel);
        block.addTo(sums);
      });
  for (Eigen::Matrix3d* H : {&sums.equations.H, &sums.equations.spurious})
    *H = H->selfadjointView<Eigen::Upper>().toDenseMatrix();
  return sums;
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
  } parts{points, config};
  forEachPairs(reference, points, T_ref_base, {config.final_pair_distance, config.kernel_scale, config},
               [&](std::size_t begin, std::size_t rows, auto&& pairsAt) {
                 for (std::size_t i = 0; i < rows; ++i) parts.add(begin + i * kLanes, pairsAt(i));
               });
  parts.end();
  return parts.pulls;
}

}  // namespace slam
