/* What turns the timeline on a board that plays alone: a potentiometer, or a motor knob (MOTOR). It
sets `hand_theta2` (rad, 0 to pi) and `hand_touches`, which the sketch's audio reads. */
#ifndef OVERVIEW_HAND_H
#define OVERVIEW_HAND_H

static volatile float hand_theta2 = 0.0f;
static volatile bool hand_touches = false;

/* A potentiometer is always held, unless a touch or a button at TOUCH_PIN pulls it to GND. */
static bool hand_is_touched() { return TOUCH_PIN < 0 || digitalRead(TOUCH_PIN) == LOW; }

#ifndef MOTOR

static void hand_begin() {
  if (TOUCH_PIN >= 0) pinMode(TOUCH_PIN, INPUT_PULLUP);
  analogReadResolution(12);
}

/* Call it from loop(): 1000 readings a second, each the mean of eight. */
static void hand_read() {
  static uint32_t due = 0;
  if (micros() - due < 1000) return;
  due = micros();
  long sum = 0;
  for (int n = 0; n < 8; n++) sum += analogRead(WIPER_PIN);
  float part = (sum / 8.0f - WIPER_LOW) / (WIPER_HIGH - WIPER_LOW);
  hand_theta2 = 3.14159265f * (part < 0 ? 0 : part > 1 ? 1 : part);
  hand_touches = hand_is_touched();
}

#else

#include <SimpleFOC.h>

// A hung loop() would hold its last torque: the chip's own watchdog restarts it, and a reset
// releases the driver's enable pin. Not on a Teensy.
#if defined(ARDUINO_ARCH_ESP32)
#include <esp_task_wdt.h>
static void hand_guard() {
  esp_task_wdt_config_t limits = {};
  limits.timeout_ms = 50;
  limits.trigger_panic = true;
  if (esp_task_wdt_reconfigure(&limits) != ESP_OK) esp_task_wdt_init(&limits);
  esp_task_wdt_add(NULL);
}
static void hand_feed() { esp_task_wdt_reset(); }
#else
static void hand_guard() {}
static void hand_feed() {}
#endif

static BLDCMotor motor = BLDCMotor(POLE_PAIRS);
static BLDCDriver3PWM driver = BLDCDriver3PWM(PHASE_A, PHASE_B, PHASE_C, ENABLE);
static MagneticSensorI2C sensor = MagneticSensorI2C(AS5048_I2C);
static Knob knob;
static KnobClock timing;
static float before;  // the shaft's angle in the latest pass, rad

static void hand_begin() {
  if (TOUCH_PIN >= 0) pinMode(TOUCH_PIN, INPUT_PULLUP);
  sensor.init();
  Wire.setClock(400000);  // at the usual 100000 a reading takes longer than a step
  motor.linkSensor(&sensor);
  driver.voltage_power_supply = SUPPLY_V;
  driver.init();
  motor.linkDriver(&driver);
  motor.voltage_limit = LIMIT_V;
  motor.controller = MotionControlType::torque;
  motor.init();
  motor.initFOC();
  before = motor.shaftAngle();
  knob_begin(&knob, before);
  overview_board_knob(&knob, OVERVIEW_KNOB, sizeof OVERVIEW_KNOB);
  hand_guard();
  knob_clock_begin(&timing, micros());
}

/* Call it from loop(), with nothing else that takes time: it turns the motor. */
static void hand_read() {
  static const uint8_t ALIVE[] = {KNOB_ALIVE, 1};
  hand_feed();
  motor.loopFOC();
  knob_take(&knob, ALIVE, sizeof ALIVE);
  knob_clock_heard(&timing, micros());
  const int count = knob_clock_due(&timing, micros());
  if (timing.stalled) knob_release(&knob);
  if (!count) return;
  const float angle = motor.shaftAngle();
  float torque = 0;
  for (int n = 1; n <= count; n++) torque = knob_step(&knob, before + (angle - before) * n / count);
  before = angle;
  motor.move(torque / NM_PER_V);
  hand_theta2 = knob.u / KNOB_PER_RAD;
  hand_touches = hand_is_touched();
}

#endif
#endif
