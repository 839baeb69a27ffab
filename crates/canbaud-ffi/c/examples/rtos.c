/* A task of FreeRTOS, Zephyr or the like: the listen-only scan, then LSS beside the application.
 *
 * The two queues are filled by the CAN interrupts; everything else is this one task, so no function
 * of canbaud is ever called twice at a time.
 */

#include "canbaud.h"

/* What the port gives: xQueueReceive or k_msgq_get with a time-out, a clock, the CAN driver. */
typedef struct can_event {
    enum { CAN_FRAME, CAN_ERROR } kind;
    uint64_t at_us;
    canbaud_frame frame;
    uint8_t error_class;
    uint8_t error_place;
} can_event;

int port_wait(can_event *event, uint64_t until_us); /* 0: it is `until_us` */
uint64_t port_now_us(void);
int port_can_listen(uint32_t bitrate); /* silent mode; 0 if it cannot */
int port_can_take_part(uint32_t bitrate);
void port_can_stop(void);
void port_can_send(const canbaud_frame *frame);
void port_boot_up(uint8_t node_id);
uint8_t port_store(void *context, canbaud_lss_configuration configuration);
void can_task(void *argument);

static const canbaud_capabilities CAPABILITIES = {
    .bitrate_min = 10000U,
    .bitrate_max = 1000000U,
    .evidence = CANBAUD_EVIDENCE_ERRORS,
    .fd = 0U,
    .reconfiguration_us = 500U,
    .latency_us = 1000U,
};

/* Carries out what the scan wants. */
static void scan_turn(canbaud_scan *scan)
{
    canbaud_scan_action action;
    while (canbaud_scan_poll(scan, port_now_us(), &action) == CANBAUD_STATUS_OK &&
           action.kind != CANBAUD_SCAN_ACTION_KIND_NONE) {
        if (action.kind == CANBAUD_SCAN_ACTION_KIND_STOP) {
            port_can_stop();
        } else if (port_can_listen(action.candidate.nominal)) {
            (void)canbaud_scan_listening(scan, port_now_us(), action.candidate.nominal, 0U);
        } else {
            (void)canbaud_scan_refused(scan, port_now_us());
        }
    }
}

/* Listens until the rate is known, and stays off the bus until then; 0 if there is none. */
static uint32_t find_rate(uint32_t last_known)
{
    static canbaud_scan scan;
    const canbaud_scan_settings settings = {.last_known = last_known};
    canbaud_scan_outcome outcome;
    can_event event;
    uint64_t deadline;

    (void)canbaud_scan_init(&scan, NULL, 0U, &CAPABILITIES, &settings);
    for (;;) {
        scan_turn(&scan);
        if (canbaud_scan_outcome_get(&scan, &outcome) == CANBAUD_STATUS_OK) {
            return outcome.kind == CANBAUD_SCAN_OUTCOME_KIND_FOUND ? outcome.nominal : 0U;
        }
        (void)canbaud_scan_deadline(&scan, &deadline);
        if (!port_wait(&event, deadline)) {
            continue;
        }
        if (event.kind == CAN_FRAME) {
            (void)canbaud_scan_frame(&scan, port_now_us(), &event.frame, event.at_us);
        } else {
            (void)canbaud_scan_error(&scan, port_now_us(), event.error_class, event.error_place,
                                     event.at_us);
        }
    }
}

/* Carries out what the slave wants. */
static void lss_turn(canbaud_lss_slave *slave, int *may_send)
{
    canbaud_lss_action action;
    while (canbaud_lss_slave_poll(slave, port_now_us(), &action) == CANBAUD_STATUS_OK) {
        switch (action.kind) {
        case CANBAUD_LSS_ACTION_KIND_SEND:
            port_can_send(&action.frame);
            break;
        case CANBAUD_LSS_ACTION_KIND_STOP_SENDING:
            *may_send = 0;
            break;
        case CANBAUD_LSS_ACTION_KIND_RESUME_SENDING:
            *may_send = 1;
            break;
        case CANBAUD_LSS_ACTION_KIND_SWITCH_BIT_RATE:
            if (action.bitrate != CANBAUD_BITRATE_AUTOMATIC) {
                (void)port_can_take_part(action.bitrate);
            } else {
                uint32_t found = 0;
                while (found == 0U) {
                    found = find_rate(0U);
                }
                (void)port_can_take_part(found);
                (void)canbaud_lss_slave_rate_found(slave);
            }
            break;
        case CANBAUD_LSS_ACTION_KIND_RESET_COMMUNICATION:
            (void)canbaud_lss_slave_reset_communication(slave);
            port_boot_up(action.node_id);
            break;
        default:
            return;
        }
    }
}

void can_task(void *argument)
{
    static canbaud_lss_slave slave;
    const canbaud_lss_address address = {0x29CU, 1U, 0x10002U, 4711U};
    const canbaud_lss_configuration *stored = argument;
    uint32_t rate = stored->bitrate;
    uint64_t deadline;
    can_event event;
    int may_send = 1;

    if (rate == CANBAUD_BITRATE_AUTOMATIC) {
        do {
            rate = find_rate(0U);
        } while (rate == 0U);
    }
    (void)port_can_take_part(rate);
    (void)canbaud_lss_slave_init(&slave, &address, stored, 1U);
    for (;;) {
        lss_turn(&slave, &may_send);
        (void)canbaud_lss_slave_deadline(&slave, &deadline);
        if (port_wait(&event, deadline) && event.kind == CAN_FRAME) {
            (void)canbaud_lss_slave_handle(&slave, port_now_us(), &event.frame, port_store, NULL);
            /* The application's frames are handled here, and sent while may_send is 1. */
        }
    }
}
