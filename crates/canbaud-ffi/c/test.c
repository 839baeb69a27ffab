/* Tests of the C API that need no C library: they run on a host and on a Cortex-M. */

#include "canbaud.h"
#include "test.h"

static unsigned failures;

static void print_number(unsigned number)
{
    char digits[11];
    unsigned at = sizeof digits - 1U;
    digits[at] = '\0';
    do {
        digits[--at] = (char)('0' + (char)(number % 10U));
        number /= 10U;
    } while (number != 0U);
    test_print(&digits[at]);
}

static void check(int holds, const char *what, unsigned line)
{
    if (!holds) {
        failures++;
        test_print("line ");
        print_number(line);
        test_print(" does not hold: ");
        test_print(what);
        test_print("\n");
    }
}

#define CHECK(condition) check((condition), #condition, (unsigned)__LINE__)
#define CHECK_OK(call) CHECK((call) == CANBAUD_STATUS_OK)

static int same(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b) {
        a++;
        b++;
    }
    return *a == *b;
}

/* 36 MHz and 500 kbit/s on bxCAN: prescaler 4 makes 18 quanta, the sample point is at 16 of them
 * (88.9 %) or prescaler 9 makes 8 with 7 (87.5 %): the word is TS2 0, TS1 5, BRP 8. */
static void test_bit_timing(void)
{
    const canbaud_timing_request request = {36000000U, 500000U, 875U, 0U};
    const canbaud_timing_request absurd = {36000000U, 36000000U, 0U, 0U};
    const canbaud_controller *bxcan = canbaud_controller_bxcan();
    canbaud_timing_solution solution;
    canbaud_register_word words[CANBAUD_REGISTERS_MAX];
    size_t count = 0;

    CHECK_OK(canbaud_timing_solve(bxcan, CANBAUD_PHASE_NOMINAL, &request, &solution));
    CHECK(solution.timing.prescaler == 9U);
    CHECK(solution.sample_point_permille == 875U);
    CHECK(solution.error_ppb == 0);
    CHECK(solution.millibits_per_second == 500000000U);
    CHECK_OK(canbaud_timing_registers(bxcan, &solution.timing, NULL, words, CANBAUD_REGISTERS_MAX,
                                      &count));
    CHECK(count == 1U);
    CHECK(same(words[0].name, "BTR") || same(words[0].name, "CAN_BTR"));
    CHECK((words[0].word & 0x007F03FFU) == 0x00050008U);
    CHECK(canbaud_timing_registers(bxcan, &solution.timing, NULL, words, 0U, &count) ==
          CANBAUD_STATUS_NO_ROOM);
    CHECK(count == 1U);
    CHECK(canbaud_timing_solve(bxcan, CANBAUD_PHASE_NOMINAL, &absurd, &solution) ==
          CANBAUD_STATUS_NO_SOLUTION);
    CHECK(canbaud_timing_solve(bxcan, CANBAUD_PHASE_DATA, &request, &solution) ==
          CANBAUD_STATUS_NO_PHASE);
    CHECK(canbaud_timing_solve(bxcan, 7U, &request, &solution) == CANBAUD_STATUS_OUT_OF_RANGE);
    CHECK(canbaud_timing_solve(NULL, CANBAUD_PHASE_NOMINAL, &request, &solution) ==
          CANBAUD_STATUS_NULL_POINTER);
}

static void test_controllers_by_name(void)
{
    const canbaud_controller *found = NULL;
    CHECK_OK(canbaud_controller_find("FDCAN", &found));
    CHECK(found != NULL);
    CHECK(canbaud_controller_find("sja2000", &found) == CANBAUD_STATUS_UNKNOWN_CONTROLLER);
    CHECK(canbaud_controller_find(NULL, &found) == CANBAUD_STATUS_NULL_POINTER);
    CHECK(same(canbaud_status_text(CANBAUD_STATUS_NO_SOLUTION), "the controller cannot do it"));
}

/* A classic data frame, identifier 0x2FB, 7 bytes, from SOF to the last bit of EOF; 0 is dominant.
 * From vectors/bits/corners.toml. */
static const char FRAME[] =
    "0010111110010000011111001111000001100000110100010011001111010100000100000101011011111001"
    "100001111101111111111";

static void push(void *detector, uint64_t at)
{
    CHECK_OK(canbaud_pulse_detector_push(detector, at));
}

static void push_compact(void *detector, uint64_t at)
{
    CHECK_OK(canbaud_compact_detector_push(detector, at));
}

/* Feeds the edges of FRAME, acknowledged, to a detector: 20 bits of idle around it. */
static uint64_t feed(void (*edge)(void *, uint64_t), void *detector, uint64_t start,
                     uint64_t ticks_per_bit)
{
    char level = '1';
    uint64_t at = start + 20U * ticks_per_bit;
    const char *bit;
    for (bit = FRAME; *bit != '\0'; bit++) {
        if (*bit != level) {
            level = *bit;
            edge(detector, at);
        }
        at += ticks_per_bit;
    }
    return at + 20U * ticks_per_bit;
}

static void test_pulse_detector(void)
{
    static canbaud_pulse_detector detector;
    canbaud_verdict verdict;
    uint64_t end;

    CHECK(canbaud_pulse_detector_push(&detector, 1U) == CANBAUD_STATUS_NOT_INITIALIZED);
    CHECK(canbaud_pulse_detector_init(NULL) == CANBAUD_STATUS_NULL_POINTER);
    CHECK_OK(canbaud_pulse_detector_init(&detector));
    CHECK_OK(canbaud_pulse_detector_verdict(&detector, &verdict));
    CHECK(verdict.kind == CANBAUD_VERDICT_KIND_NO_TRAFFIC);
    CHECK(canbaud_pulse_detector_begin(&detector, 0U, 2U) == CANBAUD_STATUS_OUT_OF_RANGE);
    CHECK_OK(canbaud_pulse_detector_begin(&detector, 0U, CANBAUD_LEVEL_HIGH));
    end = feed(push, &detector, 0U, 16U);
    CHECK_OK(canbaud_pulse_detector_finish(&detector, end));
    CHECK_OK(canbaud_pulse_detector_verdict(&detector, &verdict));
    CHECK(verdict.kind == CANBAUD_VERDICT_KIND_FOUND);
    CHECK(verdict.data_phase == CANBAUD_DATA_PHASE_NO_FD);
    CHECK(verdict.proven_frames == 1U);
    CHECK(verdict.proof_bits >= 10U);
    CHECK(verdict.inverted == 0U);
    /* 16 ticks of an 8 MHz timer: 500 kbit/s within 0.1 %. */
    CHECK(canbaud_bit_time_millibits(verdict.nominal, 8000000U, 1U) > 499500000U);
    CHECK(canbaud_bit_time_millibits(verdict.nominal, 8000000U, 1U) < 500500000U);
    CHECK(canbaud_bit_time_millibits(verdict.nominal, 0U, 1U) == 0U);
}

/* The same edges: one tick a bit is too few, 16 are enough. */
static void test_compact_detector(void)
{
    static canbaud_compact_detector detector;
    canbaud_verdict verdict;
    uint64_t end;

    CHECK(canbaud_compact_detector_push(&detector, 1U) == CANBAUD_STATUS_NOT_INITIALIZED);
    CHECK(canbaud_compact_detector_init(NULL) == CANBAUD_STATUS_NULL_POINTER);
    CHECK_OK(canbaud_compact_detector_init(&detector));
    CHECK_OK(canbaud_compact_detector_verdict(&detector, &verdict));
    CHECK(verdict.kind == CANBAUD_VERDICT_KIND_NO_TRAFFIC);
    CHECK(canbaud_compact_detector_begin(&detector, 0U, 2U) == CANBAUD_STATUS_OUT_OF_RANGE);
    CHECK_OK(canbaud_compact_detector_begin(&detector, 0U, CANBAUD_LEVEL_HIGH));
    end = feed(push_compact, &detector, 0U, 1U);
    CHECK_OK(canbaud_compact_detector_finish(&detector, end));
    CHECK_OK(canbaud_compact_detector_verdict(&detector, &verdict));
    CHECK(verdict.kind == CANBAUD_VERDICT_KIND_NEEDS_CLEAN_FRAME);
    CHECK_OK(canbaud_compact_detector_begin(&detector, end, CANBAUD_LEVEL_HIGH));
    end = feed(push_compact, &detector, end, 16U);
    CHECK_OK(canbaud_compact_detector_finish(&detector, end));
    CHECK_OK(canbaud_compact_detector_verdict(&detector, &verdict));
    CHECK(verdict.kind == CANBAUD_VERDICT_KIND_FOUND);
    CHECK(verdict.proven_frames == 1U && verdict.proof_bits >= 10U);
    CHECK(canbaud_bit_time_millibits(verdict.nominal, 8000000U, 1U) == 500000000U);
}

static const canbaud_capabilities CAPABILITIES = {10000U, 1000000U, CANBAUD_EVIDENCE_ERRORS,
                                                  0U,     500U,     0U};

/* A controller on a bus with 250 kbit/s: frames there, stuff errors elsewhere. */
static void test_scan(void)
{
    static canbaud_scan scan;
    canbaud_scan_action action;
    canbaud_scan_outcome outcome;
    canbaud_frame frame = {0x181U, 0U, CANBAUD_FRAME_KIND_DATA, 1U, 0U, {0U}};
    uint32_t rate = 0;
    uint64_t now = 0;
    uint64_t deadline = 0;
    unsigned turn;

    CHECK(canbaud_scan_poll(&scan, 0U, &action) == CANBAUD_STATUS_NOT_INITIALIZED);
    CHECK_OK(canbaud_scan_init(&scan, NULL, 0U, &CAPABILITIES, NULL));
    CHECK(canbaud_scan_outcome_get(&scan, &outcome) == CANBAUD_STATUS_NOTHING);
    for (turn = 0; turn < 1000U; turn++) {
        now += 700U;
        CHECK_OK(canbaud_scan_poll(&scan, now, &action));
        if (action.kind == CANBAUD_SCAN_ACTION_KIND_LISTEN) {
            rate = action.candidate.nominal;
            CHECK_OK(canbaud_scan_listening(&scan, now, rate, 0U));
        } else if (action.kind == CANBAUD_SCAN_ACTION_KIND_STOP) {
            break;
        } else if (rate == 250000U) {
            frame.data[0]++;
            CHECK_OK(canbaud_scan_frame(&scan, now, &frame, now));
        } else {
            CHECK_OK(canbaud_scan_error(&scan, now, CANBAUD_ERROR_CLASS_STUFF,
                                        CANBAUD_ERROR_PLACE_UNKNOWN, CANBAUD_NEVER));
        }
        CHECK_OK(canbaud_scan_deadline(&scan, &deadline));
    }
    CHECK_OK(canbaud_scan_outcome_get(&scan, &outcome));
    CHECK(outcome.kind == CANBAUD_SCAN_OUTCOME_KIND_FOUND);
    CHECK(outcome.nominal == 250000U);
    CHECK(outcome.frames >= 2U);
    CHECK(canbaud_scan_error(&scan, now, 99U, 0U, CANBAUD_NEVER) == CANBAUD_STATUS_OUT_OF_RANGE);
    frame.dlc = 16U;
    CHECK(canbaud_scan_frame(&scan, now, &frame, now) == CANBAUD_STATUS_OUT_OF_RANGE);
}

static void test_scan_candidates(void)
{
    static canbaud_scan scan;
    static const canbaud_candidate one[] = {{83333U, 0U, 1U}};
    static const canbaud_candidate none[] = {{0U, 0U, 0U}};
    const canbaud_scan_settings bad = {9U, 0U, 0U, 0U, 0U, 0U, 0U};
    canbaud_scan_action action;

    CHECK_OK(canbaud_scan_init(&scan, one, 1U, &CAPABILITIES, NULL));
    CHECK_OK(canbaud_scan_poll(&scan, 0U, &action));
    CHECK(action.kind == CANBAUD_SCAN_ACTION_KIND_LISTEN);
    CHECK(action.candidate.nominal == 83333U && action.candidate.wide == 1U);
    CHECK(canbaud_scan_init(&scan, none, 1U, &CAPABILITIES, NULL) == CANBAUD_STATUS_OUT_OF_RANGE);
    CHECK(canbaud_scan_init(&scan, NULL, 1U, &CAPABILITIES, NULL) == CANBAUD_STATUS_NULL_POINTER);
    CHECK(canbaud_scan_init(&scan, one, 1U, &CAPABILITIES, &bad) == CANBAUD_STATUS_OUT_OF_RANGE);
}

static unsigned stored;

static uint8_t store(void *context, canbaud_lss_configuration configuration)
{
    *(canbaud_lss_configuration *)context = configuration;
    stored++;
    return CANBAUD_LSS_STORE_RESULT_OK;
}

static canbaud_frame lss_command(uint8_t specifier, uint8_t first, uint8_t second)
{
    canbaud_frame frame = {0x7E5U, 0U, CANBAUD_FRAME_KIND_DATA, 8U, 0U, {0U}};
    frame.data[0] = specifier;
    frame.data[1] = first;
    frame.data[2] = second;
    return frame;
}

/* Command specifiers of CiA 305: 4 switch state global, 17 configure node-ID, 19 configure bit
 * timing, 23 store configuration. Index 3 of the table is 250 kbit/s. */
static void test_lss_slave(void)
{
    static canbaud_lss_slave slave;
    const canbaud_lss_address address = {0x29CU, 1U, 0x10002U, 4711U};
    const canbaud_lss_configuration delivered = {CANBAUD_NODE_ID_UNCONFIGURED,
                                                 CANBAUD_BITRATE_AUTOMATIC};
    canbaud_lss_configuration kept = {0U, 1U};
    canbaud_lss_action action;
    canbaud_frame commands[4];
    uint8_t in_configuration = 9U;
    unsigned at;

    commands[0] = lss_command(4U, 1U, 0U);
    commands[1] = lss_command(17U, 42U, 0U);
    commands[2] = lss_command(19U, 0U, 3U);
    commands[3] = lss_command(23U, 0U, 0U);
    CHECK_OK(canbaud_lss_slave_init(&slave, &address, &delivered, 1U));
    CHECK_OK(canbaud_lss_slave_active(&slave, &kept, &in_configuration));
    CHECK(kept.node_id == 255U && kept.bitrate == 0U && in_configuration == 0U);
    for (at = 0; at < 4U; at++) {
        CHECK_OK(canbaud_lss_slave_handle(&slave, at, &commands[at], store, &kept));
        CHECK_OK(canbaud_lss_slave_poll(&slave, at, &action));
        if (at == 0U) {
            CHECK(action.kind == CANBAUD_LSS_ACTION_KIND_NONE);
        } else {
            CHECK(action.kind == CANBAUD_LSS_ACTION_KIND_SEND);
            CHECK(action.frame.id == 0x7E4U);
            CHECK(action.frame.data[0] == commands[at].data[0]);
            CHECK(action.frame.data[1] == 0U);
        }
    }
    CHECK(stored == 1U);
    CHECK(kept.node_id == 42U);
    CHECK(kept.bitrate == 250000U);
    CHECK(canbaud_lss_slave_handle(&slave, 9U, NULL, store, &kept) == CANBAUD_STATUS_NULL_POINTER);
}

unsigned test_run(void)
{
    failures = 0;
    test_bit_timing();
    test_controllers_by_name();
    test_pulse_detector();
    test_compact_detector();
    test_scan();
    test_scan_candidates();
    test_lss_slave();
    if (failures == 0U) {
        test_print("the C API holds\n");
    }
    return failures;
}
