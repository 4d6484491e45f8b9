/* Start of a program on a bare Cortex-M core in qemu, with semihosting: it calls `run`, as `main` would. */
#include <stdint.h>
#include <stdio.h>

extern void initialise_monitor_handles(void);
extern uint32_t __stack_top__, __bss_start__, __bss_end__;
void Reset_Handler(void);
void _exit(int);

__attribute__((section(".vectors"), used)) static void *const VECTORS[] = {&__stack_top__,
                                                                          (void *)Reset_Handler};

void Reset_Handler(void) {
    uint32_t *at;
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* the floating-point unit, where there is one */
    for (at = &__bss_start__; at < &__bss_end__; at++) *at = 0;
    initialise_monitor_handles();
    at = (uint32_t *)(intptr_t)run();
    fflush(stdout);
    _exit((int)(intptr_t)at);
}
