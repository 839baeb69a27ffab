/* The C API of canbaud. Made from crates/canbaud-ffi/src; do not edit.
 *
 * Finds the bit rate of a CAN or CAN FD bus, proves it, and never disturbs the bus. All storage
 * belongs to the caller; nothing allocates, nothing blocks, and no function is reentrant for one
 * storage. docs/firmware.md shows how it is used.
 */

#ifndef CANBAUD_H
#define CANBAUD_H

#include <stddef.h>
#include <stdint.h>

/**
 * Words of a canbaud_compact_detector, of eight bytes each.
 */
#define CANBAUD_COMPACT_DETECTOR_WORDS 80

/**
 * Words of a canbaud_lss_slave, of eight bytes each.
 */
#define CANBAUD_LSS_SLAVE_WORDS 32

/**
 * The node-ID of a device that has none.
 */
#define CANBAUD_NODE_ID_UNCONFIGURED 255

/**
 * A bit rate of 0 stands for automatic detection: index 9 of the bit timing table.
 */
#define CANBAUD_BITRATE_AUTOMATIC 0

/**
 * Words of a canbaud_pulse_detector, of eight bytes each.
 */
#define CANBAUD_PULSE_DETECTOR_WORDS 192

/**
 * Most candidates of a scan.
 */
#define CANBAUD_SCAN_CANDIDATES_MAX 16

/**
 * Words of a canbaud_scan, of eight bytes each.
 */
#define CANBAUD_SCAN_WORDS 352

/**
 * No time stamp; as a deadline: never.
 */
#define CANBAUD_NEVER UINT64_MAX

/**
 * Most registers that a controller has for its bit timing.
 */
#define CANBAUD_REGISTERS_MAX 8

/**
 * What a function says. Everything but CANBAUD_STATUS_OK is a mistake of the caller or an impossible
 * request; trouble on the bus is no error.
 */
enum canbaud_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Done.
   */
  CANBAUD_STATUS_OK = 0,
  /**
   * A pointer that must not be is NULL.
   */
  CANBAUD_STATUS_NULL_POINTER = 1,
  /**
   * The storage was not set up by its init function.
   */
  CANBAUD_STATUS_NOT_INITIALIZED = 2,
  /**
   * A value is outside its documented range.
   */
  CANBAUD_STATUS_OUT_OF_RANGE = 3,
  /**
   * No controller has that name.
   */
  CANBAUD_STATUS_UNKNOWN_CONTROLLER = 4,
  /**
   * The controller cannot do it: no bit timing is near enough, or none fits its registers.
   */
  CANBAUD_STATUS_NO_SOLUTION = 5,
  /**
   * The controller does not have this phase.
   */
  CANBAUD_STATUS_NO_PHASE = 6,
  /**
   * The array has too little room; the count says how much is needed.
   */
  CANBAUD_STATUS_NO_ROOM = 7,
  /**
   * There is no such thing at the moment: no outcome yet, nothing to do.
   */
  CANBAUD_STATUS_NOTHING = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_status canbaud_status;
#else
typedef uint8_t canbaud_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a detector says.
 */
enum canbaud_verdict_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * There is no activity.
   */
  CANBAUD_VERDICT_KIND_NO_TRAFFIC = 0,
  /**
   * There were edges, but no complete frame between two stretches of idle yet.
   */
  CANBAUD_VERDICT_KIND_NEEDS_COMPLETE_FRAME = 1,
  /**
   * The edges fit no bit time: noise, another bus, or too coarse a clock.
   */
  CANBAUD_VERDICT_KIND_NEEDS_CLEAN_FRAME = 2,
  /**
   * A bit has fewer ticks than the detector can resolve.
   */
  CANBAUD_VERDICT_KIND_NEEDS_FINER_CLOCK = 3,
  /**
   * A rate fits, but the proof is too weak; another, different frame decides.
   */
  CANBAUD_VERDICT_KIND_NEEDS_ANOTHER_FRAME = 4,
  /**
   * The rate is proven.
   */
  CANBAUD_VERDICT_KIND_FOUND = 5,
  /**
   * Two nominal rates are proven on one line: `nominal` and `other`.
   */
  CANBAUD_VERDICT_KIND_CONFLICT = 6,
  /**
   * Two data rates are proven on one line: `data` and `other`.
   */
  CANBAUD_VERDICT_KIND_DATA_CONFLICT = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_verdict_kind canbaud_verdict_kind;
#else
typedef uint8_t canbaud_verdict_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What is known about the data phase of CAN FD.
 */
enum canbaud_data_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * No CAN FD frame was proven.
   */
  CANBAUD_DATA_PHASE_NO_FD = 0,
  /**
   * CAN FD frames were proven, none switched its bit rate.
   */
  CANBAUD_DATA_PHASE_NEVER_SWITCHED = 1,
  /**
   * `data` is the bit time of the data phase.
   */
  CANBAUD_DATA_PHASE_SWITCHED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_data_phase canbaud_data_phase;
#else
typedef uint8_t canbaud_data_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a slave wants done.
 */
enum canbaud_lss_action_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing: sleep until the deadline or until a frame comes.
   */
  CANBAUD_LSS_ACTION_KIND_NONE = 0,
  /**
   * Send the frame.
   */
  CANBAUD_LSS_ACTION_KIND_SEND = 1,
  /**
   * Send nothing at all until CANBAUD_LSS_ACTION_KIND_RESUME_SENDING.
   */
  CANBAUD_LSS_ACTION_KIND_STOP_SENDING = 2,
  /**
   * Set the controller to the bit rate. CANBAUD_BITRATE_AUTOMATIC: listen silently until the bit
   * rate is found, set the controller to it and call canbaud_lss_slave_rate_found.
   */
  CANBAUD_LSS_ACTION_KIND_SWITCH_BIT_RATE = 3,
  /**
   * The node may send again.
   */
  CANBAUD_LSS_ACTION_KIND_RESUME_SENDING = 4,
  /**
   * Enter the NMT state reset communication: call canbaud_lss_slave_reset_communication and boot
   * up with the node-ID.
   */
  CANBAUD_LSS_ACTION_KIND_RESET_COMMUNICATION = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_lss_action_kind canbaud_lss_action_kind;
#else
typedef uint8_t canbaud_lss_action_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a scan wants done.
 */
enum canbaud_scan_action_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Nothing: sleep until the deadline or until something is heard.
   */
  CANBAUD_SCAN_ACTION_KIND_NONE = 0,
  /**
   * Set the controller to the candidate and listen without transmitting, then call
   * canbaud_scan_listening; or canbaud_scan_refused if the controller cannot.
   */
  CANBAUD_SCAN_ACTION_KIND_LISTEN = 1,
  /**
   * Stop listening: there is an outcome.
   */
  CANBAUD_SCAN_ACTION_KIND_STOP = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_scan_action_kind canbaud_scan_action_kind;
#else
typedef uint8_t canbaud_scan_action_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Outcomes of a scan.
 */
enum canbaud_scan_outcome_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * This is the rate.
   */
  CANBAUD_SCAN_OUTCOME_KIND_FOUND = 0,
  /**
   * Nobody sends.
   */
  CANBAUD_SCAN_OUTCOME_KIND_SILENT = 1,
  /**
   * There is traffic, at none of the rates.
   */
  CANBAUD_SCAN_OUTCOME_KIND_NO_CANDIDATE_FITS = 2,
  /**
   * Nothing was heard, and this controller cannot tell a wrong rate from a silent bus.
   */
  CANBAUD_SCAN_OUTCOME_KIND_STILL_OPEN = 3,
  /**
   * The controller can be set to none of the candidates.
   */
  CANBAUD_SCAN_OUTCOME_KIND_REFUSED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_scan_outcome_kind canbaud_scan_outcome_kind;
#else
typedef uint8_t canbaud_scan_outcome_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What is known about CAN FD on the bus.
 */
enum canbaud_fd_seen
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * No CAN FD frame was received.
   */
  CANBAUD_FD_SEEN_NO = 0,
  /**
   * CAN FD frames without a bit rate switch.
   */
  CANBAUD_FD_SEEN_NEVER_SWITCHED = 1,
  /**
   * CAN FD frames with a bit rate switch.
   */
  CANBAUD_FD_SEEN_SWITCHED = 2,
  /**
   * Frames that a classic controller cannot read behind the arbitration field.
   */
  CANBAUD_FD_SEEN_SUSPECTED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_fd_seen canbaud_fd_seen;
#else
typedef uint8_t canbaud_fd_seen;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Kinds of protocol errors.
 */
enum canbaud_error_class
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Six equal bits.
   */
  CANBAUD_ERROR_CLASS_STUFF = 0,
  /**
   * A bit of fixed form has the wrong level.
   */
  CANBAUD_ERROR_CLASS_FORM = 1,
  /**
   * The CRC does not match.
   */
  CANBAUD_ERROR_CLASS_CRC = 2,
  /**
   * A bit error.
   */
  CANBAUD_ERROR_CLASS_BIT = 3,
  /**
   * Nobody acknowledged.
   */
  CANBAUD_ERROR_CLASS_ACKNOWLEDGE = 4,
  /**
   * The controller does not tell.
   */
  CANBAUD_ERROR_CLASS_UNKNOWN = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_error_class canbaud_error_class;
#else
typedef uint8_t canbaud_error_class;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Places of protocol errors.
 */
enum canbaud_error_place
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Before or in the CRC sequence.
   */
  CANBAUD_ERROR_PLACE_BEFORE_CRC_END = 0,
  /**
   * The CRC delimiter.
   */
  CANBAUD_ERROR_PLACE_CRC_DELIMITER = 1,
  /**
   * The ACK slot.
   */
  CANBAUD_ERROR_PLACE_ACK_SLOT = 2,
  /**
   * The ACK delimiter.
   */
  CANBAUD_ERROR_PLACE_ACK_DELIMITER = 3,
  /**
   * End of frame.
   */
  CANBAUD_ERROR_PLACE_END_OF_FRAME = 4,
  /**
   * Flags, delimiters, intermission.
   */
  CANBAUD_ERROR_PLACE_BETWEEN = 5,
  /**
   * The controller does not tell.
   */
  CANBAUD_ERROR_PLACE_UNKNOWN = 6,
  /**
   * The identifier and the bits up to RTR.
   */
  CANBAUD_ERROR_PLACE_ARBITRATION = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_error_place canbaud_error_place;
#else
typedef uint8_t canbaud_error_place;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a controller tells about a wrong rate.
 */
enum canbaud_evidence
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Protocol errors, one by one.
   */
  CANBAUD_EVIDENCE_ERRORS = 0,
  /**
   * An error counter only.
   */
  CANBAUD_EVIDENCE_COUNTER = 1,
  /**
   * Good frames only.
   */
  CANBAUD_EVIDENCE_FRAMES_ONLY = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_evidence canbaud_evidence;
#else
typedef uint8_t canbaud_evidence;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Kinds of frames.
 */
enum canbaud_frame_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Classic data frame.
   */
  CANBAUD_FRAME_KIND_DATA = 0,
  /**
   * Classic remote frame.
   */
  CANBAUD_FRAME_KIND_REMOTE = 1,
  /**
   * CAN FD frame without bit rate switch.
   */
  CANBAUD_FRAME_KIND_FD = 2,
  /**
   * CAN FD frame with bit rate switch.
   */
  CANBAUD_FRAME_KIND_FD_BRS = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_frame_kind canbaud_frame_kind;
#else
typedef uint8_t canbaud_frame_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Levels of a line.
 */
enum canbaud_level
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Below the threshold: dominant on RXD.
   */
  CANBAUD_LEVEL_LOW = 0,
  /**
   * Above the threshold: recessive on RXD.
   */
  CANBAUD_LEVEL_HIGH = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_level canbaud_level;
#else
typedef uint8_t canbaud_level;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What came of storing.
 */
enum canbaud_lss_store_result
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Stored.
   */
  CANBAUD_LSS_STORE_RESULT_OK = 0,
  /**
   * The device cannot store.
   */
  CANBAUD_LSS_STORE_RESULT_NOT_SUPPORTED = 1,
  /**
   * The storage medium cannot be accessed.
   */
  CANBAUD_LSS_STORE_RESULT_ACCESS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_lss_store_result canbaud_lss_store_result;
#else
typedef uint8_t canbaud_lss_store_result;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Parts of a frame that have a bit timing of their own.
 */
enum canbaud_phase
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Arbitration phase; the only one of classic CAN.
   */
  CANBAUD_PHASE_NOMINAL = 0,
  /**
   * Data phase of CAN FD.
   */
  CANBAUD_PHASE_DATA = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_phase canbaud_phase;
#else
typedef uint8_t canbaud_phase;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Policies of a scan.
 */
enum canbaud_scan_policy
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint8_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Weighs evidence.
   */
  CANBAUD_SCAN_POLICY_WEIGHING = 0,
  /**
   * The procedure of Koppe's paper.
   */
  CANBAUD_SCAN_POLICY_KOPPE = 1,
  /**
   * Each candidate for a fixed time.
   */
  CANBAUD_SCAN_POLICY_FIXED_DWELL = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum canbaud_scan_policy canbaud_scan_policy;
#else
typedef uint8_t canbaud_scan_policy;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A controller that canbaud knows: its limits and registers.
 */
typedef struct canbaud_controller canbaud_controller;

/**
 * Finds and proves the bit rate from one classic frame, with three ticks a bit or more, for the
 * smallest controllers: a fifth of the code and a third of the memory of canbaud_pulse_detector. The
 * line is RXD: high is recessive. Its content is private. Zeros are storage that is not initialized.
 */
typedef struct canbaud_compact_detector {
  /**
   * Private.
   */
  uint64_t opaque[CANBAUD_COMPACT_DETECTOR_WORDS];
} canbaud_compact_detector;

/**
 * A bit time with its uncertainty.
 */
typedef struct canbaud_bit_time {
  /**
   * Timer ticks per bit, times 2^20.
   */
  uint64_t ticks_q20;
  /**
   * One standard deviation in 10^-9.
   */
  uint32_t uncertainty_ppb;
} canbaud_bit_time;

/**
 * A verdict. What the kind does not speak of is 0.
 */
typedef struct canbaud_verdict {
  /**
   * What the detector says.
   */
  canbaud_verdict_kind kind;
  /**
   * Bit time of the arbitration phase.
   */
  struct canbaud_bit_time nominal;
  /**
   * What is known about the data phase.
   */
  canbaud_data_phase data_phase;
  /**
   * Bit time of the data phase.
   */
  struct canbaud_bit_time data;
  /**
   * The second bit time of a conflict.
   */
  struct canbaud_bit_time other;
  /**
   * Frames whose CRC and form were right at this rate.
   */
  uint32_t proven_frames;
  /**
   * The probability that the rate is wrong is at most 2 to the power of minus this.
   */
  uint32_t proof_bits;
  /**
   * 1 if the line is inverted: high is dominant.
   */
  uint8_t inverted;
} canbaud_verdict;

/**
 * The LSS slave of a CANopen device [CiA 305]. Times are microseconds of a clock of the caller that
 * never goes back. Its content is private. Zeros are storage that is not initialized.
 */
typedef struct canbaud_lss_slave {
  /**
   * Private.
   */
  uint64_t opaque[CANBAUD_LSS_SLAVE_WORDS];
} canbaud_lss_slave;

/**
 * The address of a device, object 1018h.
 */
typedef struct canbaud_lss_address {
  /**
   * Vendor-ID.
   */
  uint32_t vendor_id;
  /**
   * Product code.
   */
  uint32_t product_code;
  /**
   * Revision number.
   */
  uint32_t revision_number;
  /**
   * Serial number.
   */
  uint32_t serial_number;
} canbaud_lss_address;

/**
 * Node-ID and bit rate of a device.
 */
typedef struct canbaud_lss_configuration {
  /**
   * 1 to 127, or CANBAUD_NODE_ID_UNCONFIGURED.
   */
  uint8_t node_id;
  /**
   * Bit rate in bit/s, or CANBAUD_BITRATE_AUTOMATIC.
   */
  uint32_t bitrate;
} canbaud_lss_configuration;

/**
 * A CAN frame.
 */
typedef struct canbaud_frame {
  /**
   * Identifier: 11 bits, or 29 if `extended`.
   */
  uint32_t id;
  /**
   * 0: base format; 1: extended format.
   */
  uint8_t extended;
  /**
   * One of canbaud_frame_kind.
   */
  uint8_t kind;
  /**
   * Data length code, 0 to 15.
   */
  uint8_t dlc;
  /**
   * Error state indicator of a CAN FD frame: 0 or 1.
   */
  uint8_t esi;
  /**
   * Data; what is beyond the length that `dlc` stands for does not matter.
   */
  uint8_t data[64];
} canbaud_frame;

/**
 * Keeps a configuration over a loss of power; gives a canbaud_lss_store_result.
 */
typedef uint8_t (*canbaud_lss_store)(void *context, struct canbaud_lss_configuration configuration);

/**
 * What a slave wants done, and with what.
 */
typedef struct canbaud_lss_action {
  /**
   * What.
   */
  canbaud_lss_action_kind kind;
  /**
   * The frame to send.
   */
  struct canbaud_frame frame;
  /**
   * The bit rate to switch to.
   */
  uint32_t bitrate;
  /**
   * The node-ID to boot up with.
   */
  uint8_t node_id;
} canbaud_lss_action;

/**
 * Finds and proves the bit rate of a bus from its edges; holds any classic frame and short CAN FD
 * frames. Its content is private. Zeros are storage that is not initialized.
 */
typedef struct canbaud_pulse_detector {
  /**
   * Private.
   */
  uint64_t opaque[CANBAUD_PULSE_DETECTOR_WORDS];
} canbaud_pulse_detector;

/**
 * The scan machine: told what was heard, says what to do next. It does no I/O and has no clock:
 * times are microseconds of a clock of the caller that never goes back. Its content is private.
 * Zeros are storage that is not initialized.
 */
typedef struct canbaud_scan {
  /**
   * Private.
   */
  uint64_t opaque[CANBAUD_SCAN_WORDS];
} canbaud_scan;

/**
 * A rate to listen at.
 */
typedef struct canbaud_candidate {
  /**
   * Nominal bit rate in bit/s.
   */
  uint32_t nominal;
  /**
   * Data bit rate in bit/s; 0: classic frames.
   */
  uint32_t data;
  /**
   * 1: with the widest capture that the bit timing offers (large SJW, long PHASE_SEG2).
   */
  uint8_t wide;
} canbaud_candidate;

/**
 * What the controller can do.
 */
typedef struct canbaud_capabilities {
  /**
   * Lowest nominal bit rate in bit/s.
   */
  uint32_t bitrate_min;
  /**
   * Highest nominal bit rate in bit/s.
   */
  uint32_t bitrate_max;
  /**
   * What it tells about a wrong rate: a canbaud_evidence.
   */
  uint8_t evidence;
  /**
   * 1 if it receives CAN FD frames.
   */
  uint8_t fd;
  /**
   * Longest time that a change of the rate takes, in microseconds.
   */
  uint32_t reconfiguration_us;
  /**
   * Longest time until something that was heard is told, in microseconds.
   */
  uint32_t latency_us;
} canbaud_capabilities;

/**
 * Settings of a scan; a 0 stands for the default.
 */
typedef struct canbaud_scan_settings {
  /**
   * A canbaud_scan_policy.
   */
  uint8_t policy;
  /**
   * 1: never gives up; 0: at its bound.
   */
  uint8_t endless;
  /**
   * Share of frames that may be destroyed at the right rate, in thousandths, up to 1000.
   */
  uint16_t destroyed_permille;
  /**
   * The bit rate of the last time, which is tried first; 0: none.
   */
  uint32_t last_known;
  /**
   * Longest pause between frames to sit out, in microseconds; 0: 1 s.
   */
  uint32_t pause_us;
  /**
   * How often each candidate may be given that long; 0: 3.
   */
  uint32_t rounds;
  /**
   * How long the fixed dwell is, in microseconds; 0: 600 ms.
   */
  uint32_t dwell_us;
} canbaud_scan_settings;

/**
 * What a scan wants done, and with what.
 */
typedef struct canbaud_scan_action {
  /**
   * What.
   */
  canbaud_scan_action_kind kind;
  /**
   * The candidate to listen at.
   */
  struct canbaud_candidate candidate;
} canbaud_scan_action;

/**
 * The outcome of a scan. What the kind does not speak of is 0.
 */
typedef struct canbaud_scan_outcome {
  /**
   * What came of it.
   */
  canbaud_scan_outcome_kind kind;
  /**
   * What is known about CAN FD.
   */
  canbaud_fd_seen fd;
  /**
   * The candidate that was found; where none fits, one that may be the nominal rate of a CAN FD
   * bus.
   */
  struct canbaud_candidate candidate;
  /**
   * The nominal bit rate that the controller was really set to.
   */
  uint32_t nominal;
  /**
   * Frames received at this rate.
   */
  uint32_t frames;
  /**
   * Bursts of protocol errors met at this rate.
   */
  uint32_t errors;
  /**
   * Candidates listened to.
   */
  uint32_t visits;
  /**
   * From the first poll to the verdict, in microseconds.
   */
  uint64_t elapsed_us;
  /**
   * 1 if frames were destroyed at the ACK delimiter: nobody acknowledges.
   */
  uint8_t unacknowledged;
} canbaud_scan_outcome;

/**
 * What is asked of a bit timing.
 */
typedef struct canbaud_timing_request {
  /**
   * The clock that the controller's data sheet starts from, in Hz.
   */
  uint32_t clock_hz;
  /**
   * Bit rate in bit/s.
   */
  uint32_t bitrate;
  /**
   * Sample point in thousandths of a bit, 1 to 999; 0: what CiA recommends for the bit rate.
   */
  uint16_t sample_point_permille;
  /**
   * Largest accepted bit rate error in 10^-6; 0: 5000.
   */
  uint32_t tolerance_ppm;
} canbaud_timing_request;

/**
 * A bit timing in real values: a prescaler of 1 divides by 1, whatever the register holds for it.
 */
typedef struct canbaud_bit_timing {
  /**
   * Clock periods per time quantum.
   */
  uint16_t prescaler;
  /**
   * PROP_SEG in time quanta.
   */
  uint16_t prop_seg;
  /**
   * PHASE_SEG1 in time quanta.
   */
  uint16_t phase_seg1;
  /**
   * PHASE_SEG2 in time quanta.
   */
  uint16_t phase_seg2;
  /**
   * Synchronization jump width in time quanta.
   */
  uint16_t sjw;
} canbaud_bit_timing;

/**
 * A bit timing and what it makes of the request.
 */
typedef struct canbaud_timing_solution {
  /**
   * The bit timing.
   */
  struct canbaud_bit_timing timing;
  /**
   * Sample point in thousandths of a bit, rounded.
   */
  uint16_t sample_point_permille;
  /**
   * The bit rate that comes out, in thousandths of a bit/s.
   */
  uint64_t millibits_per_second;
  /**
   * Bit rate error in 10^-9, positive if too fast.
   */
  int64_t error_ppb;
} canbaud_timing_solution;

/**
 * A word for a register.
 */
typedef struct canbaud_register_word {
  /**
   * Name of the register as the data sheet has it, cut to 23 characters.
   */
  char name[24];
  /**
   * What to write.
   */
  uint32_t word;
} canbaud_register_word;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Sets up a detector before its first edge.
 *
 * # Safety
 * `detector` must be valid or NULL.
 */
canbaud_status canbaud_compact_detector_init(struct canbaud_compact_detector *detector);

/**
 * Unbroken recording begins at tick `at` with the line at `level`, a canbaud_level; also after a
 * pause or a lost edge.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_compact_detector_begin(struct canbaud_compact_detector *detector,
                                              uint64_t at,
                                              uint8_t level);

/**
 * An edge at tick `at`, later than the one before; the level toggles.
 *
 * Mostly some hundred instructions; the edge that ends the gap behind a frame pays for the proof.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_compact_detector_push(struct canbaud_compact_detector *detector,
                                             uint64_t at);

/**
 * The line has not changed from the last edge to tick `at`, and the recording ends or pauses:
 * canbaud_compact_detector_begin comes before the next edge.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_compact_detector_finish(struct canbaud_compact_detector *detector,
                                               uint64_t at);

/**
 * What is known so far. Once a rate is found, further edges do not change it.
 *
 * # Safety
 * `detector` and `verdict` must be valid or NULL.
 */
canbaud_status canbaud_compact_detector_verdict(struct canbaud_compact_detector *detector,
                                                struct canbaud_verdict *verdict);

/**
 * The controller with this name or alias ("bxcan", "FDCAN", "mcp2515"); upper and lower case, `-`
 * and `_` are the same. All controllers get linked: a firmware calls the function of its own one.
 *
 * # Safety
 * `name` must be NULL or end with a zero; `controller` must be valid or NULL.
 */
canbaud_status canbaud_controller_find(const char *name,
                                       const struct canbaud_controller **controller);

/**
 * NXP SJA1000 and 82C200. Clock: crystal (f_XTAL, divided by 2).
 */
const struct canbaud_controller *canbaud_controller_sja1000(void);

/**
 * Intel AN82527 and Bosch CC770. Clock: SCLK (the crystal, or half of it: CPU interface register DSC).
 */
const struct canbaud_controller *canbaud_controller_an82527(void);

/**
 * Infineon C167, C164 and ST10; C505CA and C515C hold the same two bytes. Clock: f_CPU (divided by 2 while CPS = 0).
 */
const struct canbaud_controller *canbaud_controller_c167(void);

/**
 * Infineon TwinCAN (XC16x, C161CS, XC164): ABTRL, BBTRL. Clock: f_CAN (a further 8 when DIV8X is set).
 */
const struct canbaud_controller *canbaud_controller_twincan(void);

/**
 * Infineon MultiCAN (XC2000, XE166, TC17xx, XMC1, XMC4). Clock: f_CAN (a further 8 when DIV8 is set).
 */
const struct canbaud_controller *canbaud_controller_multican(void);

/**
 * Dallas DS80C390: C0BT0, C0BT1 and the prescaler bits in COR. Clock: F_OSC (divided by CCD, 2 unless told otherwise).
 */
const struct canbaud_controller *canbaud_controller_ds80c390(void);

/**
 * ST bxCAN (STM32 F0 to F4, F7, L4). Clock: APB clock (PCLK).
 */
const struct canbaud_controller *canbaud_controller_bxcan(void);

/**
 * Bosch M_CAN from 3.1: STM32 FDCAN, TI MCAN and TCAN4550, SAM MCAN, Infineon MCMCAN. Clock: CAN kernel clock.
 */
const struct canbaud_controller *canbaud_controller_m_can(void);

/**
 * Bosch M_CAN 3.0 (SAM V71 revision A, SAMA5D2): BTP and FBTP. Clock: CAN kernel clock.
 */
const struct canbaud_controller *canbaud_controller_m_can_3_0(void);

/**
 * Microchip MCP2510, MCP2515, MCP25625; PIC18 ECAN BRGCON1 to 3. Clock: crystal (F_OSC, divided by 2).
 */
const struct canbaud_controller *canbaud_controller_mcp2515(void);

/**
 * Microchip MCP2517FD, MCP2518FD; CAN FD of dsPIC33 and PIC18-Q. Clock: SYSCLK (40 MHz at most, 80 MHz on dsPIC33).
 */
const struct canbaud_controller *canbaud_controller_mcp251xfd(void);

/**
 * NXP FlexCAN, CTRL1. Clock: CAN protocol engine clock.
 */
const struct canbaud_controller *canbaud_controller_flexcan_ctrl1(void);

/**
 * NXP FlexCAN with CBT (BTF = 1), classic. Clock: CAN protocol engine clock.
 */
const struct canbaud_controller *canbaud_controller_flexcan_cbt(void);

/**
 * NXP FlexCAN with CAN FD: CBT, FDCBT and FDCTRL. Clock: CAN protocol engine clock.
 */
const struct canbaud_controller *canbaud_controller_flexcan_fdcbt(void);

/**
 * NXP FlexCAN with enhanced bit timing (CTRL2.BTE = 1). Clock: CAN protocol engine clock.
 */
const struct canbaud_controller *canbaud_controller_flexcan_enhanced(void);

/**
 * NXP S32Z2 CANXL_SIC. Clock: CAN protocol engine clock.
 */
const struct canbaud_controller *canbaud_controller_nxp_canxl(void);

/**
 * Bosch X_CAN protocol unit (CAN XL). Clock: CAN clock (80 or 160 MHz for CAN XL).
 */
const struct canbaud_controller *canbaud_controller_x_can_prt(void);

/**
 * Espressif TWAI of the ESP32. Clock: APB clock (80 MHz).
 */
const struct canbaud_controller *canbaud_controller_esp32_twai(void);

/**
 * Espressif TWAI of ESP32-S2, S3, C3, C6 and H2. Clock: APB clock (80 MHz; C6: 40 MHz, H2: 32 MHz crystal).
 */
const struct canbaud_controller *canbaud_controller_esp32s3_twai(void);

/**
 * Espressif TWAI of the ESP32 from chip revision 2, with BRP_DIV. Clock: APB clock (80 MHz).
 */
const struct canbaud_controller *canbaud_controller_esp32_twai_rev2(void);

/**
 * CTU CAN FD (also ESP32-C5 TWAI-FD). Clock: core clock.
 */
const struct canbaud_controller *canbaud_controller_ctu_can_fd(void);

/**
 * Xilinx AXI CAN, Zynq-7000, ZynqMP. Clock: CAN reference clock.
 */
const struct canbaud_controller *canbaud_controller_xcan(void);

/**
 * Xilinx CAN FD 1.0. Clock: CAN clock.
 */
const struct canbaud_controller *canbaud_controller_xcanfd1(void);

/**
 * Xilinx and AMD CAN FD 2.0 (Versal). Clock: CAN clock.
 */
const struct canbaud_controller *canbaud_controller_xcanfd2(void);

/**
 * Atmel AT91 and SAMA5D3 CAN. Clock: MCK.
 */
const struct canbaud_controller *canbaud_controller_at91(void);

/**
 * TI HECC and eCAN. Clock: module clock.
 */
const struct canbaud_controller *canbaud_controller_ti_hecc(void);

/**
 * Bosch C_CAN and D_CAN (LPC11C, LPC43, TM4C, AM335x, TMS320F28x, Cyclone V). Clock: module clock.
 */
const struct canbaud_controller *canbaud_controller_c_can(void);

/**
 * Renesas R-Car CAN, RX and RA CAN: BCR. Clock: PCLK or CANMCLK (bit CCLKS).
 */
const struct canbaud_controller *canbaud_controller_rcan(void);

/**
 * Renesas RS-CANFD, generation 3 (RZ/G2L, R-Car 3), FD mode. Clock: DLL clock.
 */
const struct canbaud_controller *canbaud_controller_rscanfd_gen3(void);

/**
 * Renesas RS-CANFD, generation 3, classic mode. Clock: DLL clock.
 */
const struct canbaud_controller *canbaud_controller_rscanfd_gen3_classic(void);

/**
 * Renesas RS-CANFD, generation 4 (R-Car 4). Clock: DLL clock.
 */
const struct canbaud_controller *canbaud_controller_rscanfd_gen4(void);

/**
 * NXP LPC17xx, LPC21xx, LPC23xx, LPC40xx; Allwinner sun4i. Clock: PCLK.
 */
const struct canbaud_controller *canbaud_controller_lpc_can(void);

/**
 * Atmel AT90CAN32/64/128, ATmega16M1/32M1/64M1. Clock: clkIO.
 */
const struct canbaud_controller *canbaud_controller_at90can(void);

/**
 * Freescale MSCAN. Clock: bus or oscillator clock.
 */
const struct canbaud_controller *canbaud_controller_mscan(void);

/**
 * Holt HI-3110. Clock: oscillator.
 */
const struct canbaud_controller *canbaud_controller_hi3110(void);

/**
 * Cobham GRCAN: CONF. Clock: system clock.
 */
const struct canbaud_controller *canbaud_controller_grcan(void);

/**
 * IFI CAN FD. Clock: core clock.
 */
const struct canbaud_controller *canbaud_controller_ifi_canfd(void);

/**
 * Kvaser KCAN (PCIEcan). Clock: 80 MHz.
 */
const struct canbaud_controller *canbaud_controller_kvaser_kcan(void);

/**
 * Rockchip RK3568 CAN FD. Clock: CAN clock (300 MHz; the prescaler counts in twos).
 */
const struct canbaud_controller *canbaud_controller_rockchip_canfd(void);

/**
 * Renesas M16C and M32C 16-slot CAN. Clock: f_CAN.
 */
const struct canbaud_controller *canbaud_controller_m16c_can(void);

/**
 * PEAK uCAN (PCAN-USB FD, PCIe FD). Clock: 20, 24, 30, 40, 60 or 80 MHz, chosen with the timing.
 */
const struct canbaud_controller *canbaud_controller_peak_pucan(void);

/**
 * Sets up a slave in waiting, at power-on. `stored` is what was stored last. `automatic` is 1 if the
 * device can find its bit rate itself (index 9).
 *
 * # Safety
 * All pointers must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_init(struct canbaud_lss_slave *slave,
                                      const struct canbaud_lss_address *address,
                                      const struct canbaud_lss_configuration *stored,
                                      uint8_t automatic);

/**
 * Takes a received frame; what is no LSS command of a master is ignored. `store` is called with
 * `context` for "store configuration"; NULL: the device cannot store.
 *
 * # Safety
 * `slave` and `frame` must be valid or NULL; `store` must be able to be called with `context`, and
 * must not use the slave.
 */
canbaud_status canbaud_lss_slave_handle(struct canbaud_lss_slave *slave,
                                        uint64_t now_us,
                                        const struct canbaud_frame *frame,
                                        canbaud_lss_store store,
                                        void *context);

/**
 * What to do now. To be called until it wants nothing, after everything that was told, and when the
 * deadline has come.
 *
 * # Safety
 * `slave` and `action` must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_poll(struct canbaud_lss_slave *slave,
                                      uint64_t now_us,
                                      struct canbaud_lss_action *action);

/**
 * When canbaud_lss_slave_poll has to be called if no frame comes; CANBAUD_NEVER for never.
 *
 * # Safety
 * `slave` and `deadline_us` must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_deadline(struct canbaud_lss_slave *slave, uint64_t *deadline_us);

/**
 * The bit rate was found after automatic detection, and the controller is set to it.
 *
 * # Safety
 * `slave` must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_rate_found(struct canbaud_lss_slave *slave);

/**
 * The node enters the NMT state reset communication, for whatever reason.
 *
 * # Safety
 * `slave` must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_reset_communication(struct canbaud_lss_slave *slave);

/**
 * Node-ID and bit rate in use, and whether the slave is in the state configuration (1) or waiting
 * (0). `in_configuration` may be NULL.
 *
 * # Safety
 * All pointers must be valid or NULL.
 */
canbaud_status canbaud_lss_slave_active(struct canbaud_lss_slave *slave,
                                        struct canbaud_lss_configuration *configuration,
                                        uint8_t *in_configuration);

/**
 * Sets up a detector before its first edge.
 *
 * # Safety
 * `detector` must be valid or NULL.
 */
canbaud_status canbaud_pulse_detector_init(struct canbaud_pulse_detector *detector);

/**
 * Unbroken recording begins at tick `at` with the line at `level`, a canbaud_level; also after a
 * pause or a lost edge.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_pulse_detector_begin(struct canbaud_pulse_detector *detector,
                                            uint64_t at,
                                            uint8_t level);

/**
 * An edge at tick `at`, later than the one before; the level toggles.
 *
 * Mostly a few hundred instructions; the edge that ends a frame pays for the proof.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_pulse_detector_push(struct canbaud_pulse_detector *detector, uint64_t at);

/**
 * The line has not changed from the last edge to tick `at`, and the recording ends or pauses:
 * canbaud_pulse_detector_begin comes before the next edge.
 *
 * # Safety
 * `detector` must be valid or NULL, and nothing else may use it meanwhile.
 */
canbaud_status canbaud_pulse_detector_finish(struct canbaud_pulse_detector *detector, uint64_t at);

/**
 * What is known so far.
 *
 * # Safety
 * `detector` and `verdict` must be valid or NULL.
 */
canbaud_status canbaud_pulse_detector_verdict(struct canbaud_pulse_detector *detector,
                                              struct canbaud_verdict *verdict);

/**
 * The bit rate of a bit time in thousandths of a bit/s, for a timer of `ticks` ticks in `seconds`
 * seconds; 0 if it cannot be said.
 */
uint64_t canbaud_bit_time_millibits(struct canbaud_bit_time bit, uint64_t ticks, uint64_t seconds);

/**
 * Sets up a scan. `candidates` are `count` rates to try; with NULL and 0 those of CANopen.
 * `settings` may be NULL for the defaults.
 *
 * # Safety
 * `candidates` must point to `count` candidates; the others must be valid or NULL.
 */
canbaud_status canbaud_scan_init(struct canbaud_scan *scan,
                                 const struct canbaud_candidate *candidates,
                                 size_t count,
                                 const struct canbaud_capabilities *capabilities,
                                 const struct canbaud_scan_settings *settings);

/**
 * What to do now. To be called again until it wants nothing, after everything that was told, and
 * when the deadline has come.
 *
 * # Safety
 * `scan` and `action` must be valid or NULL.
 */
canbaud_status canbaud_scan_poll(struct canbaud_scan *scan,
                                 uint64_t now_us,
                                 struct canbaud_scan_action *action);

/**
 * When canbaud_scan_poll has to be called at the latest; CANBAUD_NEVER: only when something is
 * heard.
 *
 * # Safety
 * `scan` and `deadline_us` must be valid or NULL.
 */
canbaud_status canbaud_scan_deadline(struct canbaud_scan *scan, uint64_t *deadline_us);

/**
 * The controller listens since `now_us`, set to these bit rates in bit/s (`data` is 0 for classic
 * CAN).
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_listening(struct canbaud_scan *scan,
                                      uint64_t now_us,
                                      uint32_t nominal,
                                      uint32_t data);

/**
 * The controller cannot be set to the candidate.
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_refused(struct canbaud_scan *scan, uint64_t now_us);

/**
 * A frame was received from the bus, at `received_us` or, with CANBAUD_NEVER, some time before
 * now.
 *
 * # Safety
 * `scan` and `frame` must be valid or NULL.
 */
canbaud_status canbaud_scan_frame(struct canbaud_scan *scan,
                                  uint64_t now_us,
                                  const struct canbaud_frame *frame,
                                  uint64_t received_us);

/**
 * The controller reported a protocol error: a canbaud_error_class at a canbaud_error_place, at
 * `received_us` or, with CANBAUD_NEVER, some time before now.
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_error(struct canbaud_scan *scan,
                                  uint64_t now_us,
                                  uint8_t class_,
                                  uint8_t place,
                                  uint64_t received_us);

/**
 * The receive error counter, of a controller that counts but does not report errors.
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_receive_errors(struct canbaud_scan *scan,
                                           uint64_t now_us,
                                           uint16_t counter);

/**
 * Edges on the line since the last call, where they are counted.
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_edges(struct canbaud_scan *scan, uint64_t now_us, uint32_t edges);

/**
 * Frames or errors were lost: the FIFO overran.
 *
 * # Safety
 * `scan` must be valid or NULL.
 */
canbaud_status canbaud_scan_lost(struct canbaud_scan *scan, uint64_t now_us);

/**
 * What came of the scan; CANBAUD_STATUS_NOTHING before its end.
 *
 * # Safety
 * `scan` and `outcome` must be valid or NULL.
 */
canbaud_status canbaud_scan_outcome_get(struct canbaud_scan *scan,
                                        struct canbaud_scan_outcome *outcome);

/**
 * The text of a status, one short English line. Never NULL.
 */
const char *canbaud_status_text(uint32_t status);

/**
 * Finds the best bit timing: smallest bit rate error, then smallest sample point error.
 * `phase` is a canbaud_phase.
 *
 * CANBAUD_STATUS_NO_SOLUTION: the controller cannot make the bit rate from that clock.
 *
 * # Safety
 * `controller` must come from this library; `request` and `solution` must be valid or NULL.
 */
canbaud_status canbaud_timing_solve(const struct canbaud_controller *controller,
                                    uint8_t phase,
                                    const struct canbaud_timing_request *request,
                                    struct canbaud_timing_solution *solution);

/**
 * The words for the registers of a controller. `data` is the bit timing of the CAN FD data phase,
 * with transmitter delay compensation on if that is advisable, or NULL for classic CAN.
 *
 * `words` has room for `room` words; `count` becomes how many there are. With CANBAUD_REGISTERS_MAX
 * there is always room.
 *
 * # Safety
 * `controller` must come from this library; `words` must have room for `room` words; all others
 * must be valid or NULL.
 */
canbaud_status canbaud_timing_registers(const struct canbaud_controller *controller,
                                        const struct canbaud_bit_timing *nominal,
                                        const struct canbaud_bit_timing *data,
                                        struct canbaud_register_word *words,
                                        size_t room,
                                        size_t *count);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CANBAUD_H */
