// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/lidar/codec/rplidar_codec.hpp"

/// Capsules: packets of samples of which only the first one's angle is told, so that a capsule can be placed only when
/// the next one has come. All begin with two bytes of sync nibble and checksum nibble, then the start angle with S.
namespace slam::rplidar {

struct CapsuleHead {
  std::uint16_t start_angle_q6 = 0;  ///< [deg * 64] raw, clockwise
  bool start = false;                ///< S bit: the scan began, or the encoder was reset
};
inline constexpr std::size_t kCapsuleHeadSize = 4, kCapsuleAngleAt = 2;
/// @param bytes    a whole capsule of any kind
/// @param angle_at [bytes] where its start angle stands. @return std::nullopt for wrong sync nibbles or checksum
std::optional<CapsuleHead> parseCapsuleHead(std::span<const std::uint8_t> bytes,
                                            std::size_t angle_at = kCapsuleAngleAt);
/// Has it the sync nibbles of a capsule, whatever its checksum?
bool hasCapsuleSync(std::span<const std::uint8_t> bytes);
/// Writes start angle, S bit, sync nibbles and the checksum of what stands behind the head.
void sealCapsule(const CapsuleHead& head, std::span<std::uint8_t> bytes, std::size_t angle_at = kCapsuleAngleAt);

/// Angle of sample k of a capsule before correction, and whether it is the last one before the zero direction: with
/// that one a turn begins. Exact at k = count, so that neighbouring capsules neither miss nor double a turn.
struct RawAngle {
  int q16 = 0;  ///< [deg * 65536] 0 .. below a turn
  bool start = false;
};
class CapsuleSpan {
 public:
  CapsuleSpan(std::uint16_t start_angle_q6, std::uint16_t next_start_angle_q6, int count);
  RawAngle at(int k) const;
  int widthQ6() const { return width_q6_; }  ///< [deg * 64] turned from this capsule to the next

 private:
  int start_q6_, width_q6_, count_;
};

/// Express capsule `82`, 84 bytes: 32 samples.
inline constexpr std::size_t kExpressCapsuleSize = 84;
inline constexpr int kExpressSamples = 32;
struct ExpressCapsule {
  std::uint16_t start_angle_q6 = 0;
  bool start = false;
  struct Sample {
    std::uint16_t distance_mm = 0;  ///< 14 bits; 0: no echo
    std::uint8_t offset_q3 = 0;     ///< [deg / 8] 0..63, to be taken off the raw angle
  };
  std::array<Sample, kExpressSamples> samples{};
};
std::array<std::uint8_t, kExpressCapsuleSize> encodeExpressCapsule(const ExpressCapsule& capsule);
/// @return std::nullopt for wrong sync nibbles or checksum
std::optional<ExpressCapsule> parseExpressCapsule(std::span<const std::uint8_t> bytes);
/// Samples of `capsule` as nodes, their angles interpolated to the start angle of the capsule after it.
std::array<Node, kExpressSamples> decodeExpress(const ExpressCapsule& capsule, std::uint16_t next_start_angle_q6);

/// Ultra capsule `84`, 132 bytes: 96 samples in 32 cabins of one distance and two differences to it.
inline constexpr std::size_t kUltraCapsuleSize = 132;
inline constexpr int kUltraCabins = 32, kUltraSamples = 3 * kUltraCabins;
inline constexpr int kNoPrediction = -512;  ///< as predict: that sample has no echo (the device also uses +511)
struct UltraCapsule {
  std::uint16_t start_angle_q6 = 0;
  bool start = false;
  struct Cabin {
    std::uint16_t major = 0;  ///< 12 bits, the first distance in a scale that coarsens with it; 0: no echo
    std::int16_t predict1 = kNoPrediction, predict2 = kNoPrediction;  ///< 10 bits, signed
  };
  std::array<Cabin, kUltraCabins> cabins{};
};
std::array<std::uint8_t, kUltraCapsuleSize> encodeUltraCapsule(const UltraCapsule& capsule);
std::optional<UltraCapsule> parseUltraCapsule(std::span<const std::uint8_t> bytes);
/// The last sample is told relative to the next capsule's first cabin.
std::array<Node, kUltraSamples> decodeUltra(const UltraCapsule& capsule, const UltraCapsule& next);

/// A distance in the scale of UltraCapsule::Cabin::major.
struct ScaledDistance {
  int mm = 0;
  int level = 0;  ///< predictions count in steps of 2^level mm
};
ScaledDistance decodeMajor(std::uint16_t major);
/// The nearest value of the scale; 28656 mm at most.
std::uint16_t encodeMajor(int mm);
/// Cabins for 96 distances [mm]. A difference that ten bits cannot hold becomes "no echo", as in the device.
/// @param next_first the first distance of the capsule after it
std::array<UltraCapsule::Cabin, kUltraCabins> encodeUltraCabins(std::span<const int, kUltraSamples> distances,
                                                                int next_first);
/// What the triangulating unit's angle is off [deg * 65536] at a distance; to be taken off the raw angle.
int ultraAngleOffsetQ16(std::uint32_t distance_q2);

/// Dense capsule `85`, 84 bytes: 40 distances, angles without correction.
inline constexpr std::size_t kDenseCapsuleSize = 84;
inline constexpr int kDenseSamples = 40;
struct DenseCapsule {
  std::uint16_t start_angle_q6 = 0;
  bool start = false;
  std::array<std::uint16_t, kDenseSamples> distances_mm{};  ///< 0: no echo
};
std::array<std::uint8_t, kDenseCapsuleSize> encodeDenseCapsule(const DenseCapsule& capsule);
std::optional<DenseCapsule> parseDenseCapsule(std::span<const std::uint8_t> bytes);
std::array<Node, kDenseSamples> decodeDense(const DenseCapsule& capsule, std::uint16_t next_start_angle_q6);

/// Ultra-dense capsule `86` of newer S units, 170 bytes: 64 samples of 20 bits, angles without correction. Its time
/// stamp and status word are not used.
inline constexpr std::size_t kUltraDenseCapsuleSize = 170, kUltraDenseAngleAt = 8;
inline constexpr int kUltraDenseSamples = 64;
struct UltraDenseCapsule {
  std::uint16_t start_angle_q6 = 0;
  bool start = false;
  struct Sample {
    std::uint32_t distance_q2 = 0;  ///< [mm * 4] in steps of 2 to 5 mm, 262088 at most; 0: no echo
    std::uint8_t quality = 0;       ///< its low bits are lost at a distance
  };
  std::array<Sample, kUltraDenseSamples> samples{};
};
UltraDenseCapsule::Sample decodeUltraDenseSample(std::uint32_t bits);
/// The nearest value of the scale.
std::uint32_t encodeUltraDenseSample(const UltraDenseCapsule::Sample& sample);
std::array<std::uint8_t, kUltraDenseCapsuleSize> encodeUltraDenseCapsule(const UltraDenseCapsule& capsule);
std::optional<UltraDenseCapsule> parseUltraDenseCapsule(std::span<const std::uint8_t> bytes);
std::array<Node, kUltraDenseSamples> decodeUltraDense(const UltraDenseCapsule& capsule,
                                                      std::uint16_t next_start_angle_q6);

inline constexpr std::uint8_t kCapsuleQuality = 0x2F;  ///< capsules carry none; the vendor's value for a valid sample

}  // namespace slam::rplidar
