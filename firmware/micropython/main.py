# A sensor for overView DSP on a board with MicroPython: Pico, ESP32, Pyboard, micro:bit.
#
# Wiring   MPU-6050: 3V3, GND, and SDA and SCL to the pins of PINS below. Without one, a
#          potentiometer: its ends to 3V3 and GND, the wiper to the third pin. A micro:bit needs
#          nothing: it has an accelerometer; hold it with its pins towards the wrist.
# Flash    copy this file to the board as main.py (Thonny, or mpremote cp main.py :)
# Play     overview play MATCH --input serial:PORT
# Prints on reset
#          # overview micropython 1: mpu6050, 100 a second
#          ax,ay,az,gx,gy,gz
#          0.05,-0.02,9.79,0.001,0.000,-0.002

import sys

try:
    from utime import sleep_ms, ticks_ms
except ImportError:
    from time import sleep_ms, ticks_ms

RATE_HZ = 100
# SDA, SCL and wiper by sys.platform: Pico; ESP32 (8 and 9 on an S3 and C3; never 6 to 11 of an
# ESP32, which are its flash); Pyboard
PINS = {"rp2": (4, 5, 26), "esp32": (21, 22, 34), "esp32s3": (8, 9, 4), "esp32c3": (8, 9, 4),
        "pyboard": ("X10", "X9", "X19")}  # fmt: skip
ADDRESS = 0x68


# in m/s2 and rad/s
def mpu6050(i2c):
    for register, value in ((0x6B, 1), (0x1A, 2), (0x1B, 0x18), (0x1C, 0x18)):
        i2c.writeto_mem(ADDRESS, register, bytes((value,)))

    def number(data, at, unit):
        value = data[at] << 8 | data[at + 1]
        return "{:.4f}".format((value - 65536 if value > 32767 else value) * unit)

    def read():
        data = i2c.readfrom_mem(ADDRESS, 0x3B, 14)
        acc = [number(data, at, 9.80665 / 2048) for at in (0, 2, 4)]
        return ",".join(acc + [number(data, at, 0.00106422) for at in (8, 10, 12)])

    return "mpu6050", "ax,ay,az,gx,gy,gz", read


# the sensor's name, its columns, and a function that reads it
def found():
    try:
        from microbit import accelerometer

        # gravity's direction: x to the right, y to the pins, z out of the face (face up: -1024);
        # printed is the opposite, with x to the fingers and y to the left
        def read():
            x, y, z = accelerometer.get_values()
            return "{},{},{}".format(y, x, -z)

        return "micro:bit", "ax,ay,az", read
    except ImportError:
        import machine
    board = sys.platform
    for chip in ("s3", "c3"):
        if chip in getattr(sys.implementation, "_machine", "").lower():
            board += chip
    sda, scl, wiper = PINS.get(board, PINS["rp2"])
    try:
        i2c = machine.I2C(0, sda=machine.Pin(sda), scl=machine.Pin(scl), freq=400000)
        if ADDRESS in i2c.scan():
            return mpu6050(i2c)
    except (OSError, ValueError, TypeError):  # the board has no such pins
        pass
    adc = machine.ADC(machine.Pin(wiper))
    return "potentiometer", "pot", lambda: str(adc.read_u16() >> 6)


def run(name, columns, read):
    print("# overview micropython 1: {}, {} a second".format(name, RATE_HZ))
    began, lines = ticks_ms(), 0
    while True:
        if lines % RATE_HZ == 0:
            print(columns)  # the columns' names, once a second
        print(read())
        lines += 1
        late = ticks_ms() - began - lines * 1000 // RATE_HZ
        if late < 0:
            sleep_ms(-late)
        elif late > 100:  # too slow for the rate: skip samples instead of catching up
            began, lines = ticks_ms(), 0


run(*found())
