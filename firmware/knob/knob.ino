/* A motor under the knob, with the surface on its own board, so that no delay of USB is felt.

Needs    a 32-bit board with 40 kB of RAM (STM32F4, RP2040, ESP32, Teensy; with less, say
         #define KNOB_POINTS 1025 below), the library SimpleFOC (2.1 or later), a gimbal motor, a
         driver, an encoder of 14 bits (AS5048, MA730; an AS5600 has 12 and gives weaker knocks)
Wiring   driver to pins 9, 5, 6 (phases) and 8 (enable); encoder to SDA and SCL; the motor's supply
         to the driver, GND of all together
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

const int POLE_PAIRS = 7;
const float SUPPLY_V = 12, LIMIT_V = 6;  // the board never exceeds this limit
const float NM_PER_V = 0.003;            // 8.27 / KV / phase resistance

BLDCMotor motor = BLDCMotor(POLE_PAIRS);
BLDCDriver3PWM driver = BLDCDriver3PWM(9, 5, 6, 8);
MagneticSensorI2C sensor = MagneticSensorI2C(AS5048_I2C);

static Knob knob;

void setup() {
  Serial.begin(1000000);
  sensor.init();
  motor.linkSensor(&sensor);
  driver.voltage_power_supply = SUPPLY_V;
  driver.init();
  motor.linkDriver(&driver);
  motor.voltage_limit = LIMIT_V;
  motor.controller = MotionControlType::torque;
  motor.init();
  motor.initFOC();
  knob_begin(&knob, motor.shaftAngle());
  Serial.println("# overview knob 1: frames, 500 a second, the surface 4000 times a second");
  Serial.write((uint8_t)0);
}

void loop() {
  static unsigned long due = micros();
  static int steps = 0;
  motor.loopFOC();
  while (Serial.available()) knob_receive(&knob, Serial.read());
  if ((long)(micros() - due) < 0) return;
  due += 1000000UL / KNOB_HZ;
  motor.move(knob_step(&knob, motor.shaftAngle()) / NM_PER_V);
  if (++steps < KNOB_HZ / 500) return;
  steps = 0;
  uint8_t frame[24];
  Serial.write(frame, knob_report(&knob, micros(), frame));
}
