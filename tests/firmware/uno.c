/* An Arduino Uno in simavr on a pseudo-terminal, its sensor in a hand.

    uno FIRMWARE.elf LINK SECONDS pot|encoder|mpu6050|mpu6500|mpu9250|icm20689|clone72|lsm6ds3|bno055 REST_S

The hand rests for REST_S, then turns from one end of the timeline to the other in 3 s, stays for 3 s,
turns back and stays, again and again. The emulated time goes with the clock's; prints bytes sent and lost on the way at the end. With `-` for
LINK it goes as fast as it can, and each byte sent is printed with its time and the hand's turn (0..1). */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pty.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "avr_adc.h"
#include "avr_ioport.h"
#include "avr_twi.h"
#include "avr_uart.h"
#include "sim_avr.h"
#include "sim_elf.h"

enum { COUNTS = 40 };

static avr_t *avr;
static int terminal;
static long sent, unsent;
static const char *kind;
static double rest;
static volatile sig_atomic_t stopped;

static double seconds(void) { return (double)avr->cycle / avr->frequency; }

static double turned_at(double t) { /* 0 to 1 */
    double part;
    if (t < rest) return 0.0;
    t = fmod(t - rest, 11.0);
    part = t < 6.0 ? fmin(1.0, t / 3.0) : fmax(0.0, (9.0 - t) / 3.0);
    return part * part * (3.0 - 2.0 * part);
}

static double turned(void) { return turned_at(seconds()); }

static int noise(void) { return rand() % 3 - 1; }

/* --- UART ------------------------------------------------------------------------------------- */

static void from_uart(struct avr_irq_t *irq, uint32_t value, void *param) {
    uint8_t byte = (uint8_t)value;
    (void)irq, (void)param;
    if (!terminal) printf("%.6f %.6f %02x\n", seconds(), turned(), byte);
    else if (write(terminal, &byte, 1) == 1) sent++;
    else unsent++; /* nobody reads, and the buffer is full */
}

static void to_uart(void) {
    uint8_t data[64];
    ssize_t count = read(terminal, data, sizeof data);
    for (ssize_t i = 0; i < count; i++)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), data[i]);
}

/* --- a potentiometer and an encoder ----------------------------------------------------------- */

static void convert(struct avr_irq_t *irq, uint32_t value, void *param) {
    (void)irq, (void)value, (void)param;
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0),
                  (uint32_t)(5000.0 * turned()) + 3 * (noise() + 1)); /* mV */
}

static void turn_encoder(void) {
    static long at;
    long want = lround(COUNTS * turned());
    static const uint8_t STATES[4] = {3, 2, 0, 1}; /* B A: the way the sketch counts up */
    if (want == at) return;
    at += want > at ? 1 : -1;
    for (int pin = 0; pin < 2; pin++)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2 + pin),
                      STATES[((at % 4) + 4) % 4] >> pin & 1);
}

/* --- an inertial sensor on the two-wire bus ----------------------------------------------------

Registers hold what is written to them, and decide what is measured: asleep, powered down or in its
configuration mode a chip measures nothing; the range sets the size of the numbers and their limit. */

static const struct {
    const char *kind;
    uint8_t identity, power; /* WHO_AM_I (0x75), PWR_MGMT_1 (0x6B) after a reset: 0x40 is asleep */
} MPUS[] = {{"mpu6050", 0x68, 0x40}, {"mpu6500", 0x70, 0x01}, {"mpu9250", 0x71, 0x01},
            {"icm20689", 0x98, 0x41}, {"clone72", 0x72, 0x40}};

static uint8_t chosen, number, memory[2][256]; /* the second page is the BNO055's */
static int written;

static int is(const char *name) { return !strcmp(kind, name); }
static int is_mpu(void) { return !is("lsm6ds3") && !is("bno055"); }
static uint8_t page(void) { return is("bno055") ? memory[0][0x07] & 1 : 0; }

static void reset_sensor(void) {
    for (unsigned i = 0; i < sizeof MPUS / sizeof *MPUS; i++)
        if (is(MPUS[i].kind)) {
            memory[0][0x75] = MPUS[i].identity;
            memory[0][0x6B] = MPUS[i].power;
        }
    if (is("lsm6ds3")) {
        memory[0][0x0F] = 0x69;
        memory[0][0x12] = 0x04; /* register addresses count up */
    } else if (is("bno055")) {
        memory[0][0x00] = 0xA0;
        memory[0][0x3B] = 0x80; /* m/s2 */
        memory[1][0x08] = 0x0D; /* 4 g */
        memory[1][0x0A] = 0x38; /* 2000 deg/s */
    }
}

static void put(uint8_t *at, double value, double limit, int big) {
    value = fmax(-limit, fmin(limit, value)) + noise();
    int16_t whole = (int16_t)fmax(-32768, fmin(32767, lround(value)));
    at[big] = (uint8_t)whole;
    at[!big] = (uint8_t)(whole >> 8);
}

static void measure(uint8_t at) {
    static const double LSM_G[4] = {2, 16, 4, 8}, LSM_DEG_S[4] = {250, 500, 1000, 2000};
    uint8_t *all = memory[0];
    double angle = M_PI * 175.0 / 180.0 * turned();
    double speed[3] = {175.0 * (turned() - turned_at(seconds() - 1e-3)) / 1e-3, 0, 0}; /* deg/s */
    double g[3] = {0.0, sin(angle), cos(angle)};
    for (int i = 0; i < 3; i++) {
        if (is_mpu()) {
            if (at != 0x3B || all[0x6B] & 0x40) return;
            put(all + 0x3B + 2 * i, 16384.0 / (1 << (all[0x1C] >> 3 & 3)) * g[i], 32767, 1);
            put(all + 0x43 + 2 * i, 131.0 / (1 << (all[0x1B] >> 3 & 3)) * speed[i], 32767, 1);
        } else if (is("lsm6ds3")) {
            double full = LSM_G[all[0x10] >> 2 & 3], fast = LSM_DEG_S[all[0x11] >> 2 & 3];
            if (at == 0x28 && all[0x10] >> 4)
                put(all + 0x28 + 2 * i, g[i] / (full * 0.0305e-3), 32767, 0);
            if (at == 0x22 && all[0x11] >> 4)
                put(all + 0x22 + 2 * i, speed[i] / (fast * 35e-6), 32767, 0);
        } else {
            uint8_t mode = all[0x3D] & 15;
            double full = 2 << (memory[1][0x08] & 3), unit = all[0x3B] & 1 ? 1000.0 : 980.665;
            double fast = 2000.0 / (1 << (memory[1][0x0A] & 7));
            if (at == 0x08 && mode) put(all + 0x08 + 2 * i, unit * g[i], unit * full, 0);
            if (at == 0x14 && (mode == 3 || mode >= 5))
                put(all + 0x14 + 2 * i, 16.0 * speed[i], 16.0 * fast, 0);
        }
    }
}

static void write_register(uint8_t value) {
    int configured = is("bno055") && memory[0][0x3D] & 15; /* then only the mode can be written */
    if (!configured || number == 0x3D || number == 0x07) memory[number == 0x07 ? 0 : page()][number] = value;
    number++;
}

static uint8_t registers(void) {
    uint8_t value;
    if (!page()) measure(number);
    value = memory[number == 0x07 ? 0 : page()][number];
    if (!is("lsm6ds3") || memory[0][0x12] & 0x04) number++;
    return value;
}

static void answer(uint8_t message, uint8_t data) {
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT),
                  avr_twi_irq_msg(message, chosen, data));
}

static void on_bus(struct avr_irq_t *irq, uint32_t value, void *param) {
    uint8_t address = is_mpu() ? 0x68 : is("lsm6ds3") ? 0x6A : 0x28;
    avr_twi_msg_irq_t said;
    (void)irq, (void)param;
    said.u.v = value;
    if (said.u.twi.msg & TWI_COND_STOP) chosen = 0;
    if (said.u.twi.msg & TWI_COND_START) {
        written = 0;
        chosen = said.u.twi.addr >> 1 == address ? said.u.twi.addr : 0;
        if (chosen) answer(TWI_COND_ACK, 1);
    }
    if (!chosen) return;
    if (said.u.twi.msg & TWI_COND_WRITE) {
        if (!written++) number = said.u.twi.data;
        else write_register(said.u.twi.data);
        answer(TWI_COND_ACK, 1);
    }
    if (said.u.twi.msg & TWI_COND_READ) answer(TWI_COND_READ, registers());
}

/* --- the board --------------------------------------------------------------------------------- */

static void stop(int signal_number) {
    (void)signal_number;
    stopped = 1;
}

static double clock_s(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

static int open_terminal(const char *link) {
    struct termios raw;
    int theirs;
    if (openpty(&terminal, &theirs, NULL, NULL, NULL)) return 0;
    tcgetattr(theirs, &raw);
    cfmakeraw(&raw);
    tcsetattr(theirs, TCSANOW, &raw);
    fcntl(terminal, F_SETFL, O_NONBLOCK);
    unlink(link);
    return symlink(ptsname(terminal), link) == 0;
}

int main(int count, char **words) {
    elf_firmware_t firmware = {0};
    uint32_t flags = 0;
    if (count != 6 || elf_read_firmware(words[1], &firmware)) return 2;
    kind = words[4];
    rest = atof(words[5]);
    reset_sensor();
    if (strcmp(words[2], "-") && !open_terminal(words[2])) return 3;
    signal(SIGTERM, stop);
    signal(SIGINT, stop);
    avr = avr_make_mcu_by_name("atmega328p");
    avr_init(avr);
    avr->frequency = 16000000;
    avr_load_firmware(avr, &firmware);
    avr->frequency = 16000000;
    avr->vcc = avr->avcc = avr->aref = 5000;
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
    flags &= ~(uint32_t)(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POLL_SLEEP);
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT),
                            from_uart, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_OUT_TRIGGER), convert,
                            NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT), on_bus,
                            NULL);
    printf("serial:%s\n", words[2]);
    fflush(stdout);
    double began = clock_s(), until = atof(words[3]);
    while (!stopped && seconds() < until) {
        double now = terminal ? clock_s() - began : seconds() + 1e-3;
        if (now - seconds() > 0.5) began += now - seconds(); /* held up: that time is lost */
        while (seconds() < now && now - seconds() < 0.5) {
            int state = avr_run(avr);
            if (state == cpu_Done || state == cpu_Crashed) return 5;
        }
        if (!strcmp(kind, "encoder")) turn_encoder();
        if (!terminal) continue;
        to_uart();
        usleep(300);
    }
    if (!terminal) return 0;
    unlink(words[2]);
    printf("{\"sent\": %ld, \"unsent\": %ld}\n", sent, unsent);
    return 0;
}
