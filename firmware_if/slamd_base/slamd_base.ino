// SPDX-License-Identifier: BSD-3-Clause
// Reference firmware of a base with two driven wheels: quadrature encoders, an H-bridge with a PWM and two direction
// inputs for each motor, and an MPU-6050 or MPU-9250 on I2C. For an Arduino Uno, Nano, Mega, or a board with an RP2040.
// It sends STATE 100 times a second and stops the motors 200 ms after the last SPEEDS: see docs/base-frame.md.
#include <Arduino.h>
#include <Wire.h>
#if defined(__AVR__)
#include <avr/wdt.h>
#endif

#include "base_control.hpp"
#include "base_frame.hpp"

using namespace slamd_base;

// Of the robot: set these.
const bool kReversed[2] = {false, false};                    // left, right: its encoder counts down driving forward
const bool kMotorReversed[2] = {false, false};               // left, right: it turns backwards at a positive duty
const ControlGains kGains = {3000.0F, 0.8F, 4.0F};           // [counts/s] at full duty, [1], [1/s]
const uint8_t kEncoderA[2] = {2, 3}, kEncoderB[2] = {4, 7};  // A: pins with an interrupt
const uint8_t kPwm[2] = {5, 6}, kForward[2] = {8, 10}, kBackward[2] = {9, 11};
const int kBumperPin = -1, kWheelDropPin = -1;  // switch to ground; -1: none
const int kBatteryPin = -1;                     // analogue; -1: none
const float kBatteryUnit = 15.0F;               // [mV] of a step of that input, with its divider

const uint32_t kPeriod = 1000000UL / kStateRate;           // [us]
const uint8_t kGyroAddress = 0x68, kPowerRegister = 0x6B;  // of an MPU-6050
const uint8_t kFilterRegister = 0x1A, kFilter42Hz = 0x03, kGyroZRegister = 0x47;
const float kGyroUnit = 17453.293F / 131.0F;  // [urad/s] of a digit at 250 degrees/s
const uint32_t kI2cPatience = 3000;           // [us]
const uint32_t kGyroPause = 1000000;          // [us] between attempts to start one that does not answer

volatile int32_t encoder_counts[2] = {0, 0};
BaseControl control(kGains);
Receiver receiver;
uint32_t last_step = 0, last_gyro_start = 0;  // [us]
bool has_gyro = false;

// Two counts in each period of the encoder: both edges of A.
void countEdge(uint8_t side) {
  const bool same = digitalRead(kEncoderA[side]) == digitalRead(kEncoderB[side]);
  encoder_counts[side] = encoder_counts[side] + (same != kReversed[side] ? 1 : -1);
}
void countLeft() { countEdge(0); }
void countRight() { countEdge(1); }

void drive(uint8_t side, float duty) {
  if (kMotorReversed[side]) duty = -duty;
  digitalWrite(kForward[side], duty > 0.0F ? HIGH : LOW);
  digitalWrite(kBackward[side], duty < 0.0F ? HIGH : LOW);
  analogWrite(kPwm[side], static_cast<int>(255.0F * (duty < 0.0F ? -duty : duty)));
}

bool writeGyro(uint8_t address, uint8_t value) {
  Wire.beginTransmission(kGyroAddress);
  Wire.write(address);
  Wire.write(value);
  return Wire.endTransmission() == 0;
}

bool startGyro() { return writeGyro(kPowerRegister, 0) && writeGyro(kFilterRegister, kFilter42Hz); }

// Its own offset is left in: slamd finds it while the robot stands.
bool readGyro(int32_t* turn_rate) {
  Wire.beginTransmission(kGyroAddress);
  Wire.write(kGyroZRegister);
  if (Wire.endTransmission(false) != 0 || Wire.requestFrom(kGyroAddress, static_cast<uint8_t>(2)) != 2) return false;
  const uint8_t high = static_cast<uint8_t>(Wire.read()), low = static_cast<uint8_t>(Wire.read());
  const int16_t digits = static_cast<int16_t>(static_cast<uint16_t>(high) << 8 | low);
  *turn_rate = static_cast<int32_t>(kGyroUnit * digits);
  return true;
}

bool isPressed(int pin) { return pin >= 0 && digitalRead(static_cast<uint8_t>(pin)) == LOW; }

void sendState(uint32_t now, const int32_t counts[2]) {
  State state = {now, {counts[0], counts[1]}, 0, 0, control.number(), 0};
  if (!has_gyro && now - last_gyro_start >= kGyroPause) {
    last_gyro_start = now;
    has_gyro = startGyro();
  }
  has_gyro = has_gyro && readGyro(&state.turn_rate);
  state.flags = static_cast<uint8_t>((has_gyro ? kHasGyro : 0) | (isPressed(kWheelDropPin) ? kLifted : 0) |
                                     (isPressed(kBumperPin) ? kBumped : 0) | (control.driven() ? kDriven : 0));
  if (kBatteryPin >= 0)
    state.battery = static_cast<uint16_t>(kBatteryUnit * static_cast<float>(analogRead(kBatteryPin)));
  uint8_t frame[kLongestFrame];
  const uint8_t size = encodeState(state, frame);
  if (Serial.availableForWrite() >= size) Serial.write(frame, size);  // a host that does not read must not hold it up
}

void setup() {
  for (uint8_t side = 0; side < 2; ++side) {
    pinMode(kPwm[side], OUTPUT);
    pinMode(kForward[side], OUTPUT);
    pinMode(kBackward[side], OUTPUT);
    drive(side, 0.0F);
    pinMode(kEncoderA[side], INPUT_PULLUP);
    pinMode(kEncoderB[side], INPUT_PULLUP);
  }
  if (kBumperPin >= 0) pinMode(static_cast<uint8_t>(kBumperPin), INPUT_PULLUP);
  if (kWheelDropPin >= 0) pinMode(static_cast<uint8_t>(kWheelDropPin), INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(kEncoderA[0]), countLeft, CHANGE);
  attachInterrupt(digitalPinToInterrupt(kEncoderA[1]), countRight, CHANGE);
  Serial.begin(kBaud);
  Wire.begin();
#if defined(WIRE_HAS_TIMEOUT)
  Wire.setWireTimeout(kI2cPatience, true);
#endif
  has_gyro = startGyro();
  // A loop that hangs must not leave the motors running.
#if defined(__AVR__)
  wdt_enable(WDTO_250MS);
#elif defined(ARDUINO_ARCH_RP2040) && !defined(ARDUINO_ARCH_MBED)
  rp2040.wdt_begin(kCommandLasts);
#endif
}

void loop() {
#if defined(__AVR__)
  wdt_reset();
#elif defined(ARDUINO_ARCH_RP2040) && !defined(ARDUINO_ARCH_MBED)
  rp2040.wdt_reset();
#endif
  while (Serial.available() > 0) {
    receiver.push(static_cast<uint8_t>(Serial.read()), [](const uint8_t* frame) {
      Speeds speeds;
      if (parseSpeeds(frame, &speeds)) control.command(speeds, micros());
    });
  }
  const uint32_t now = micros();
  if (now - last_step < kPeriod) return;
  last_step = now - last_step < 2 * kPeriod ? last_step + kPeriod : now;
  noInterrupts();
  const int32_t counts[2] = {encoder_counts[0], encoder_counts[1]};
  interrupts();
  control.step(now, counts);
  for (uint8_t side = 0; side < 2; ++side) drive(side, control.duty(side));
  sendState(now, counts);
}
