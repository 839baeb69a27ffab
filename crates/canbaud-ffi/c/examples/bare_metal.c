/* Bare metal: a timer captures the edges of RXD, the main loop finds the rate and sets bxCAN.
 *
 * TIM2 of an STM32F0 (32 bits, at 8 MHz) captures both edges of the pin that RXD is also wired to.
 * CAN_TX stays a GPIO input with pull-up until the rate is known, so the line stays recessive
 * whatever the software does.
 */

#include "canbaud.h"

#define TIMER_HZ 8000000U
#define PCLK_HZ 48000000U
#define EDGES 256U /* a power of two */

/* What the board support gives: registers behind names. */
extern volatile uint32_t TIM2_CCR1;
extern volatile uint32_t TIM2_CNT;
extern volatile uint32_t TIM2_SR;
extern volatile uint32_t CAN_BTR;
void board_init_timer(void);
int board_rxd_is_high(void);
void board_start_can(void);
void board_sleep(void);
void TIM2_IRQHandler(void);

#define TIM_SR_CC1IF (UINT32_C(1) << 1)
#define TIM_SR_CC1OF (UINT32_C(1) << 9)

static volatile uint32_t edges[EDGES];
static volatile uint32_t written; /* by the interrupt only */
static volatile uint32_t lost;

/* The whole interrupt: a store. The detector runs in the main loop. */
void TIM2_IRQHandler(void)
{
    if ((TIM2_SR & TIM_SR_CC1OF) != 0U) {
        TIM2_SR = ~TIM_SR_CC1OF;
        lost++;
    }
    edges[written % EDGES] = TIM2_CCR1; /* reading it clears CC1IF */
    written++;
}

static canbaud_pulse_detector detector;

/* The recorded ticks go on where the 32 bits of the timer end. */
static uint64_t extend(uint64_t last, uint32_t stamp)
{
    return last + (uint32_t)(stamp - (uint32_t)last);
}

/* Sets the bit timing for a measured rate; 0 if the controller cannot make it. */
static int set_bit_timing(uint64_t millibits_per_second)
{
    const canbaud_timing_request request = {PCLK_HZ, (uint32_t)((millibits_per_second + 500U) / 1000U),
                                            0U, 0U};
    const canbaud_controller *bxcan = canbaud_controller_bxcan();
    canbaud_timing_solution solution;
    canbaud_register_word word;
    size_t count;

    if (canbaud_timing_solve(bxcan, CANBAUD_PHASE_NOMINAL, &request, &solution) !=
            CANBAUD_STATUS_OK ||
        canbaud_timing_registers(bxcan, &solution.timing, NULL, &word, 1U, &count) !=
            CANBAUD_STATUS_OK) {
        return 0;
    }
    CAN_BTR = word.word;
    return 1;
}

int main(void)
{
    uint64_t now = 0;
    uint32_t taken = 0;
    uint32_t lost_before = 0;
    canbaud_verdict verdict;

    board_init_timer();
    (void)canbaud_pulse_detector_init(&detector);
    (void)canbaud_pulse_detector_begin(&detector, 0U,
                                       board_rxd_is_high() ? CANBAUD_LEVEL_HIGH : CANBAUD_LEVEL_LOW);
    for (;;) {
        if (lost != lost_before || written - taken > EDGES) {
            /* An edge is missing: what was recorded so far ends here. */
            lost_before = lost;
            taken = written;
            now = extend(now, TIM2_CNT);
            (void)canbaud_pulse_detector_begin(
                &detector, now, board_rxd_is_high() ? CANBAUD_LEVEL_HIGH : CANBAUD_LEVEL_LOW);
        } else if (taken != written) {
            now = extend(now, edges[taken % EDGES]);
            taken++;
            (void)canbaud_pulse_detector_push(&detector, now);
        } else {
            (void)canbaud_pulse_detector_verdict(&detector, &verdict);
            if (verdict.kind == CANBAUD_VERDICT_KIND_FOUND &&
                set_bit_timing(canbaud_bit_time_millibits(verdict.nominal, TIMER_HZ, 1U))) {
                board_start_can();
                return 0;
            }
            board_sleep();
        }
    }
}
