/* Plays the file `gesture` in the voice of a board that plays alone, and writes the file `samples`
(click and tactor in turn, float). On this machine, or on a bare Arm core in qemu (semihosting).

`gesture`: int32 number of samples, then of each control event int32 sample, float theta2, int32
touching. Prints each strike (sample, event, level), and at the end the strikes lost and, on Arm, the
mean and the highest number of instructions a sample, of blocks of BLOCK samples. */
#include <stdio.h>
#define OVERVIEW_STRUCK(voice, event, level) \
    printf("strike %lu %d %.6f\n", (unsigned long)(voice)->clock, (int)(event), (double)(level))
#include "overview_board.h"
#include "timeline.h"

#ifndef BLOCK
#define BLOCK 64 /* samples */
#endif
typedef struct {
    int32_t sample;
    float theta2;
    int32_t touching;
} Control;

static OverviewBoard voice;

#if defined(__arm__)
/* with -icount shift=0, an instruction takes 1 ns of the emulator's time, and the timer counts 25 MHz */
#define TIMER ((volatile uint32_t *)0xE000E010)
static void start(void) {
    TIMER[1] = 0xFFFFFF;
    TIMER[2] = 0;
    TIMER[0] = 5;
}
static double instructions(void) { return 40.0 * (0xFFFFFF - TIMER[2]); }
#else
static void start(void) {}
static double instructions(void) { return 0.0; }
#endif

/* not inlined: it saves floating-point registers, which are switched on before it */
__attribute__((noinline)) static int run(void) {
    static float click[BLOCK], tactor[BLOCK], both[2 * BLOCK];
    FILE *gesture = fopen("gesture", "rb"), *samples = fopen("samples", "wb");
    double all = 0.0, highest = 0.0, taken;
    int32_t frames, done = 0, n, i;
    Control next;
    int more;
    if (!gesture || !samples || fread(&frames, sizeof frames, 1, gesture) != 1) return 1;
    overview_board_init(&voice, &OVERVIEW_TIMELINE);
    more = fread(&next, sizeof next, 1, gesture) == 1;
    while (done < frames) {
        n = frames - done < BLOCK ? frames - done : BLOCK;
        while (more && next.sample <= done) {
            overview_board_set(&voice, next.theta2, next.touching);
            more = fread(&next, sizeof next, 1, gesture) == 1;
        }
        if (more && next.sample < done + n) n = next.sample - done;
        start();
        overview_board_process(&voice, click, tactor, (int)n);
        taken = instructions();
        all += taken;
        if (n == BLOCK && taken / n > highest) highest = taken / n;
        for (i = 0; i < n; i++) both[2 * i] = click[i], both[2 * i + 1] = tactor[i];
        fwrite(both, sizeof *both, (size_t)(2 * n), samples);
        done += n;
    }
    fclose(samples);
    printf("end %lu %.1f %.1f %lu\n", (unsigned long)voice.lost, all / frames, highest,
           (unsigned long)sizeof voice);
    return 0;
}

#if defined(__arm__)
#include "cortex_m_start.h"
#else
int main(void) { return run(); }
#endif
