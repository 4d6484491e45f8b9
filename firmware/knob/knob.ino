/* A motor under the knob, with the surface on its own board, so that no delay of USB is felt.

Needs    a 32-bit board with 40 kB of RAM (STM32F4, RP2040, ESP32, Teensy; with less, say
         #define KNOB_POINTS 1025 below), the library SimpleFOC (2.1 or later), a gimbal motor, a
         driver, an encoder of 14 bits (AS5048, MA730; an AS5600 has 12 and gives weaker knocks)
Wiring   driver to pins 9, 5, 6 (phases) and 8 (enable; ESP32: 25, 26, 27 and 33; ESP32-S3: 4, 5, 6
         and 7; RP2040: 10, 11, 12 and 13); encoder to SDA and SCL; the motor's supply to the driver,
         GND of all together
Set      the six numbers below: the torque is wrong if one of them is
Flash    Arduino IDE: open this folder's knob.ino, choose board and port, upload; on reset the knob
         turns a little by itself: don't touch it until it stops
Play     overview play MATCH --input serial:PORT,sensor=simplefoc,force,baud=1000000
Prints on reset
         # overview knob 1: frames, 500 a second, the surface 4000 times a second
*/

#define KNOB_HZ 4000              // fewer, but at least 1000, if loop() takes longer
#define KNOB_RESOLUTION 3.835e-4f  // rad: 2 pi / 16384

#include <SimpleFOC.h>

#include "surface.h"
#include "timing.h"

// A hung loop() would hold its last torque: the chip's own watchdog restarts it, and a reset
// releases the driver's enable pin.
#if defined(ARDUINO_ARCH_RP2040)
#include <hardware/watchdog.h>
static void guard() { watchdog_enable(50, true); }
static void feed() { watchdog_update(); }
#elif defined(ARDUINO_ARCH_ESP32)
#include <esp_idf_version.h>
#include <esp_task_wdt.h>
#if ESP_IDF_VERSION_MAJOR >= 5
static void guard() {
  esp_task_wdt_config_t limits = {};
  limits.timeout_ms = 50;
  limits.trigger_panic = true;
  if (esp_task_wdt_reconfigure(&limits) != ESP_OK) esp_task_wdt_init(&limits);
  esp_task_wdt_add(NULL);
}
#else
static void guard() {  // whole seconds only
  esp_task_wdt_init(1, true);
  esp_task_wdt_add(NULL);
}
#endif
static void feed() { esp_task_wdt_reset(); }
#else
static void guard() {}
static void feed() {}
#endif

const int POLE_PAIRS = 7;
const float SUPPLY_V = 12, LIMIT_V = 6;  // the board never exceeds this limit
const float NM_PER_V = 0.003;            // 8.27 / KV / phase resistance

BLDCMotor motor = BLDCMotor(POLE_PAIRS);
#if defined(CONFIG_IDF_TARGET_ESP32)  // 6 to 11 are its flash
BLDCDriver3PWM driver = BLDCDriver3PWM(25, 26, 27, 33);
#elif defined(ESP32)  // S3, C3
BLDCDriver3PWM driver = BLDCDriver3PWM(4, 5, 6, 7);
#elif defined(ARDUINO_ARCH_RP2040)  // 4 and 5 are SDA and SCL
BLDCDriver3PWM driver = BLDCDriver3PWM(10, 11, 12, 13);
#else
BLDCDriver3PWM driver = BLDCDriver3PWM(9, 5, 6, 8);
#endif
MagneticSensorI2C sensor = MagneticSensorI2C(AS5048_I2C);

static Knob knob;
static KnobClock timing;
static float before;  // the shaft's angle in the latest pass, rad

void setup() {
  Serial.begin(1000000);
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
  Serial.println("# overview knob 1: frames, 500 a second, the surface 4000 times a second");
  Serial.write((uint8_t)0);
  guard();
  knob_clock_begin(&timing, micros());
}

void loop() {
  feed();
  motor.loopFOC();
  while (Serial.available())
    if (knob_receive(&knob, Serial.read())) knob_clock_heard(&timing, micros());
  const uint32_t now = micros();
  const int count = knob_clock_due(&timing, now);
  if (!timing.alive || timing.stalled) knob_release(&knob);
  if (count) {
    const float angle = motor.shaftAngle();
    float torque = 0;
    for (int n = 1; n <= count; n++) torque = knob_step(&knob, before + (angle - before) * n / count);
    before = angle;
    motor.move(timing.alive ? torque / NM_PER_V : 0);
  }
  if (!knob_clock_tells(&timing, now)) return;
  uint8_t frame[24];
  Serial.write(frame, knob_report(&knob, now, frame));
}
