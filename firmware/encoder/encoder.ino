/* A rotary encoder turns the timeline: 40 counts for the whole of it, or the number in the sensor's
file ([encoder] counts; `overview sensor setup` measures it).

Wiring   common to GND, A to pin 2, B to pin 3 (pins with interrupts; ESP32: any), no resistors
Flash    Arduino IDE: open this folder's encoder.ino, choose board and port, upload
Play     overview play MATCH --input serial:PORT
Prints on reset
         # overview encoder 1: lines of count, 200 a second
         count
         0
*/

const int A = 2, B = 3;
const int RATE_HZ = 200;

volatile long count = 0;

#if defined(ESP32) || defined(ESP8266)
void IRAM_ATTR moved() {
#else
void moved() {
#endif
  // from the states before and now: a step forward, back, or none (if both changed, one was missed)
  static const signed char STEPS[16] = {0, 1, -1, 0, -1, 0, 0, 1, 1, 0, 0, -1, 0, -1, 1, 0};
  static unsigned char states = 3;
  states = ((states << 2) | (digitalRead(A) ? 1 : 0) | (digitalRead(B) ? 2 : 0)) & 15;
  count += STEPS[states];
}

void setup() {
  Serial.begin(115200);
  pinMode(A, INPUT_PULLUP);
  pinMode(B, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(A), moved, CHANGE);
  attachInterrupt(digitalPinToInterrupt(B), moved, CHANGE);
  Serial.println(F("# overview encoder 1: lines of count, 200 a second"));
}

void loop() {
  static unsigned long due = micros();
  static int line = 0;
  if ((long)(micros() - due) < 0) return;
  due += 1000000UL / RATE_HZ;
  if (line == 0) Serial.println(F("count"));  // the column's name, once a second
  line = (line + 1) % RATE_HZ;
  noInterrupts();
  long now = count;
  interrupts();
  Serial.println(now);
}
