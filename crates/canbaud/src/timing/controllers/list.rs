//! All controllers by name.

use super::*;

/// Every controller that canbaud knows.
pub const ALL: &[&Controller] = &[
    &sja1000::CONTROLLER,
    &an82527::CONTROLLER,
    &c167::CONTROLLER,
    &twincan::CONTROLLER,
    &multican::CONTROLLER,
    &ds80c390::CONTROLLER,
    &bxcan::CONTROLLER,
    &m_can::CONTROLLER,
    &m_can_3_0::CONTROLLER,
    &mcp2515::CONTROLLER,
    &mcp251xfd::CONTROLLER,
    &flexcan_ctrl1::CONTROLLER,
    &flexcan_cbt::CONTROLLER,
    &flexcan_fdcbt::CONTROLLER,
    &flexcan_enhanced::CONTROLLER,
    &nxp_canxl::CONTROLLER,
    &x_can_prt::CONTROLLER,
    &esp32_twai::CONTROLLER,
    &esp32s3_twai::CONTROLLER,
    &esp32_twai_rev2::CONTROLLER,
    &ctu_can_fd::CONTROLLER,
    &xcan::CONTROLLER,
    &xcanfd1::CONTROLLER,
    &xcanfd2::CONTROLLER,
    &at91::CONTROLLER,
    &ti_hecc::CONTROLLER,
    &c_can::CONTROLLER,
    &rcan::CONTROLLER,
    &rscanfd_gen3::CONTROLLER,
    &rscanfd_gen3_classic::CONTROLLER,
    &rscanfd_gen4::CONTROLLER,
    &lpc_can::CONTROLLER,
    &at90can::CONTROLLER,
    &mscan::CONTROLLER,
    &hi3110::CONTROLLER,
    &grcan::CONTROLLER,
    &ifi_canfd::CONTROLLER,
    &kvaser_kcan::CONTROLLER,
    &rockchip_canfd::CONTROLLER,
    &m16c_can::CONTROLLER,
    &peak_pucan::CONTROLLER,
];

/// The controller with this name or alias; upper and lower case, `-` and `_` are
/// the same.
///
/// ```
/// use canbaud::timing::controllers;
/// assert_eq!(controllers::find("FDCAN").unwrap().name, "m_can");
/// assert!(controllers::find("sja2000").is_none());
/// ```
#[must_use]
pub fn find(name: &str) -> Option<&'static Controller> {
    ALL.iter()
        .copied()
        .find(|c| is_same(c.name, name) || c.aliases.iter().any(|alias| is_same(alias, name)))
}

fn is_same(known: &str, given: &str) -> bool {
    let plain = |b: u8| if b == b'-' { b'_' } else { b.to_ascii_lowercase() };
    known.bytes().map(plain).eq(given.bytes().map(plain))
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    #[test]
    fn no_name_or_alias_means_two_controllers() {
        let names: Vec<&str> =
            ALL.iter().flat_map(|c| c.aliases.iter().copied().chain([c.name])).collect();
        for (index, name) in names.iter().enumerate() {
            let later = names.iter().skip(index + 1);
            assert!(!later.clone().any(|other| is_same(name, other)), "{name} is there twice");
        }
    }

    #[test]
    fn every_controller_says_what_it_is() {
        for controller in ALL {
            let texts =
                [controller.name, controller.description, controller.clock, controller.source];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}", controller.name);
        }
    }
}
