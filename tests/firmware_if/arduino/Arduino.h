// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the sketch uses of Arduino's core, for a test on this computer: pins, clock and serial port of one board.
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

enum : std::uint8_t { LOW = 0, HIGH = 1, INPUT = 0, OUTPUT = 1, INPUT_PULLUP = 2, CHANGE = 1 };

namespace arduino_board {
struct Board {
  std::uint32_t micros = 0;
  std::array<std::uint8_t, 32> level{};  // of the digital pins
  std::array<int, 32> pwm{};
  std::array<void (*)(), 32> on_change{};
  std::deque<std::uint8_t> received;  // by the board
  std::vector<std::uint8_t> sent;
  int room = 64;                  // [bytes] of the buffer of what is sent
  bool gyro = true;               // answers on I2C
  std::int16_t gyro_digits = 0;   // about z
  std::vector<std::uint8_t> i2c;  // written since the last beginTransmission()
  std::size_t i2c_read = 0;

  void set(std::uint8_t pin, std::uint8_t value) {
    const bool changes = level[pin] != value;
    level[pin] = value;
    if (changes && on_change[pin] != nullptr) on_change[pin]();
  }
};
inline Board board;
}  // namespace arduino_board

inline std::uint32_t micros() { return arduino_board::board.micros; }
inline void pinMode(std::uint8_t pin, std::uint8_t mode) {
  if (mode == INPUT_PULLUP) arduino_board::board.level[pin] = HIGH;
}
inline int digitalRead(std::uint8_t pin) { return arduino_board::board.level[pin]; }
inline void digitalWrite(std::uint8_t pin, std::uint8_t value) { arduino_board::board.level[pin] = value; }
inline void analogWrite(std::uint8_t pin, int value) { arduino_board::board.pwm[pin] = value; }
inline int analogRead(int) { return 0; }
inline std::uint8_t digitalPinToInterrupt(std::uint8_t pin) { return pin; }
inline void attachInterrupt(std::uint8_t interrupt, void (*call)(), int) {
  arduino_board::board.on_change[interrupt] = call;
}
inline void noInterrupts() {}
inline void interrupts() {}

struct ArduinoSerial {
  void begin(std::uint32_t baud) { rate = baud; }
  int available() const { return static_cast<int>(arduino_board::board.received.size()); }
  int read() {
    const int byte = arduino_board::board.received.front();
    arduino_board::board.received.pop_front();
    return byte;
  }
  int availableForWrite() const { return arduino_board::board.room; }
  void write(const std::uint8_t* bytes, std::size_t size) {
    arduino_board::board.sent.insert(arduino_board::board.sent.end(), bytes, bytes + size);
  }
  std::uint32_t rate = 0;
};
inline ArduinoSerial Serial;
