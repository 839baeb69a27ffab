//! What the detector and the decoder cost a microcontroller in memory.

use canbaud::detect::PulseDetector;
use canbaud::detect::scan::Scan;
use canbaud::wire::Decoder;

#[test]
fn detector_for_classic_frames_fits_two_kibibytes() {
    let bytes = size_of::<PulseDetector<160>>();
    assert!(bytes <= 2048, "{bytes} bytes");
}

#[test]
fn memory_grows_by_four_bytes_a_run_and_nothing_else() {
    let runs = 640;
    let per_detector = size_of::<PulseDetector<800>>() - size_of::<PulseDetector<160>>();
    assert_eq!(per_detector, 4 * runs);
    assert_eq!(size_of::<Decoder<800>>() - size_of::<Decoder<160>>(), 4 * runs);
}

/// A node with a timer and eight rates; what it searches with takes turns in the same memory.
#[test]
fn autonomous_node_fits_three_kibibytes() {
    let bytes = size_of::<canbaud::node::Node<160, 8>>();
    assert!(bytes <= 3072, "{bytes} bytes");
}

/// What `docs/scan.md` says of a 64-bit machine: nothing is larger elsewhere.
#[cfg(target_pointer_width = "64")]
#[test]
fn scan_takes_what_is_written() {
    let bytes = size_of::<Scan<8>>();
    let each = (size_of::<Scan<108>>() - size_of::<Scan<8>>()) / 100;
    let written =
        format!("A scan over eight candidates takes {bytes} bytes, each further one {each}.");
    assert!(include_str!("../../../docs/scan.md").contains(&written), "{written}");
    assert!(bytes <= 1024 && each <= 80, "{written}");
}
