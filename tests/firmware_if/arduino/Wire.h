// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "Arduino.h"

/// An I2C bus with an MPU-6050, of which the rate about z can be read.
struct ArduinoWire {
  void begin() {}
  void beginTransmission(std::uint8_t) { arduino_board::board.i2c.clear(); }
  void write(std::uint8_t byte) { arduino_board::board.i2c.push_back(byte); }
  std::uint8_t endTransmission(bool = true) { return arduino_board::board.gyro ? 0 : 2; }
  std::uint8_t requestFrom(std::uint8_t, std::uint8_t count) {
    arduino_board::board.i2c_read = 0;
    const bool is_rate = arduino_board::board.i2c == std::vector<std::uint8_t>{0x47};
    return arduino_board::board.gyro && is_rate ? count : 0;
  }
  int read() {
    const auto digits = static_cast<std::uint16_t>(arduino_board::board.gyro_digits);
    return arduino_board::board.i2c_read++ == 0 ? digits >> 8 : digits & 0xFF;
  }
};
inline ArduinoWire Wire;
