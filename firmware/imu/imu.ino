/* An inertial sensor in the hand: turned from face up to face down, it plays the timeline. Finds an
MPU-6050 (or its kin and copies: MPU-6500, MPU-9250, ICM-20689), an LSM6DS3 or a BNO055 by itself and
sends checked frames, 200 a second.

Wiring   SDA to SDA (Uno, Nano: A4), SCL to SCL (A5), GND to GND, VIN to 5V (bare chips: 3V3);
         other boards: docs/guide/boards.md
         x points from the wrist to the fingers, z out of the face; mounted differently, run
         `overview sensor setup PORT -o mine.toml` once
Flash    Arduino IDE: open this folder's imu.ino, choose board and port, upload
Play     overview play MATCH --input serial:PORT          (with pip install '.[sensors]')
Prints on reset
         # overview imu 1: MPU-6050, frames, 200 a second
     or  # overview imu 1: no sensor answers; looks again     (each second: check SDA and SCL)
*/

#include <Wire.h>

#include "frame.h"

const int RATE_HZ = 200;

enum Chip { NONE, MPU6050, LSM6DS3, BNO055 };

// boards sold as MPU-6050 carry any of these, with the same registers: WHO_AM_I of the MPU-6050,
// MPU-6500, MPU-9250, a copy, MPU-9255, ICM-20689
const uint8_t MPUS[] = {0x68, 0x70, 0x71, 0x72, 0x73, 0x98};
const uint8_t LSMS[] = {0x69, 0x6A, 0x6C};  // LSM6DS3, LSM6DS3TR-C and LSM6DSL, LSM6DSO and LSM6DSOX

Chip chip = NONE;
uint8_t address, identity;

void writeRegister(uint8_t number, uint8_t value) {
  Wire.beginTransmission(address);
  Wire.write(number);
  Wire.write(value);
  Wire.endTransmission();
}

bool readRegisters(uint8_t number, uint8_t *data, uint8_t count) {
  Wire.beginTransmission(address);
  Wire.write(number);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(address, count) != count) return false;
  for (uint8_t i = 0; i < count; i++) data[i] = Wire.read();
  return true;
}

bool answers(uint8_t at, uint8_t number, const uint8_t *known, uint8_t count) {
  address = at;
  if (!readRegisters(number, &identity, 1)) return false;
  for (uint8_t i = 0; i < count; i++)
    if (identity == known[i]) return true;
  return false;
}

Chip found() {
  const uint8_t bno = 0xA0;
  for (uint8_t second = 0; second < 2; second++) {  // each chip has two addresses
    if (answers(0x68 + second, 0x75, MPUS, sizeof MPUS)) return MPU6050;
    if (answers(0x6A + second, 0x0F, LSMS, sizeof LSMS)) return LSM6DS3;
    if (answers(0x28 + second, 0x00, &bno, 1)) return BNO055;
  }
  return NONE;
}

void begin() {  // 16 g and 2000 deg/s, filtered below 100 Hz
  if (chip == MPU6050) {
    writeRegister(0x6B, 0x01);  // out of sleep, with the gyroscope's clock
    writeRegister(0x1A, 0x02);
    writeRegister(0x19, 0x04);  // 1 kHz / 5
    writeRegister(0x1B, 0x18);
    writeRegister(0x1C, 0x18);
    if (identity != 0x68) writeRegister(0x1D, 0x02);  // these filter the acceleration apart
  } else if (chip == LSM6DS3) {
    writeRegister(0x12, 0x44);  // no half-written samples, register addresses count up
    writeRegister(0x10, 0x54);  // 208 Hz
    writeRegister(0x11, 0x5C);
  } else {
    writeRegister(0x3D, 0x00);  // configuration mode
    delay(25);
    writeRegister(0x07, 0x01);  // page 1
    writeRegister(0x08, 0x13);
    writeRegister(0x0A, 0x10);
    writeRegister(0x07, 0x00);
    writeRegister(0x3B, 0x01);  // mg
    writeRegister(0x3D, 0x05);  // raw accelerometer and gyroscope
    delay(10);
  }
}

int16_t scaled(int16_t value, int32_t by) {  // times by / 16384, limited to 16 bits
  int32_t product = ((int32_t)value * by) >> 14;
  return product > 32767 ? 32767 : product < -32768 ? -32768 : product;
}

bool sample(int16_t values[6]) {  // 1/2048 g, 1/16.384 deg/s
  uint8_t data[14];
  if (chip == MPU6050) {
    if (!readRegisters(0x3B, data, 14)) return false;
    for (uint8_t i = 0; i < 6; i++) {
      uint8_t at = 2 * i + (i < 3 ? 0 : 2);  // skips the temperature
      values[i] = (int16_t)((uint16_t)data[at] << 8 | data[at + 1]);
    }
    return true;
  }
  bool lsm = chip == LSM6DS3;
  if (!readRegisters(lsm ? 0x28 : 0x08, data, 6)) return false;
  if (!readRegisters(lsm ? 0x22 : 0x14, data + 6, 6)) return false;
  for (uint8_t i = 0; i < 6; i++) {
    int16_t raw = (int16_t)((uint16_t)data[2 * i + 1] << 8 | data[2 * i]);
    if (lsm) values[i] = i < 3 ? raw : scaled(raw, 18790);    // 70 mdeg/s a count
    else values[i] = scaled(raw, i < 3 ? 33554 : 16777);      // 1 mg, 1/16 deg/s a count
  }
  return true;
}

void setup() {
  Serial.begin(115200);
#if defined(CONFIG_IDF_TARGET_ESP32)
  Wire.begin(21, 22);
#elif defined(ESP32)  // S3, C3
  Wire.begin(8, 9);
#else
  Wire.begin();
#endif
  Wire.setClock(400000);
}

void look() {
  chip = found();
  if (chip == NONE) {
    Serial.println(F("# overview imu 1: no sensor answers; looks again"));
    delay(1000);
    return;
  }
  begin();
  Serial.print(F("# overview imu 1: "));
  Serial.print(chip == MPU6050 ? F("MPU-6050") : chip == LSM6DS3 ? F("LSM6DS3") : F("BNO055"));
  Serial.println(F(", frames, 200 a second"));
  Serial.write((uint8_t)0);  // ends any bytes before the first frame
}

void loop() {
  static unsigned long due = micros();
  int16_t values[6];
  if (chip == NONE) {
    look();
    due = micros();
    return;
  }
  if ((long)(micros() - due) < 0) return;
  due += 1000000UL / RATE_HZ;
  uint32_t now = micros();
  if (sample(values)) sendFrame(now, values);
  else chip = NONE;  // disconnected
}
