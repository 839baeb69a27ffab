/* The tests on a Cortex-M in QEMU, with output and exit code by semihosting. */

#include "../test.h"
#include <stdint.h>

extern uint32_t stack_top;
extern uint32_t bss_begin;
extern uint32_t bss_end;

static uint32_t semihosting(uint32_t operation, uintptr_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void test_print(const char *text)
{
    (void)semihosting(0x04U, (uintptr_t)text);
}

static void exit_with(unsigned failed)
{
    for (;;) {
        (void)semihosting(0x18U, failed == 0U ? 0x20026U : 0x20023U);
    }
}

void reset(void);

void reset(void)
{
    for (uint32_t *word = &bss_begin; word < &bss_end; word++) {
        *word = 0U;
    }
    exit_with(test_run());
}

static void fault(void)
{
    test_print("fault\n");
    exit_with(1U);
}

/* Stack, reset, NMI, hard fault and the three other faults. */
__attribute__((section(".vectors"), used)) static const uintptr_t VECTORS[] = {
    (uintptr_t)&stack_top, (uintptr_t)&reset, (uintptr_t)&fault, (uintptr_t)&fault,
    (uintptr_t)&fault,     (uintptr_t)&fault, (uintptr_t)&fault,
};
