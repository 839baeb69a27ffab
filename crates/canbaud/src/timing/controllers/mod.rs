//! Controllers: their limits, and their registers, packed and unpacked.
//!
//! One file per register layout, each pure data. Real values everywhere else: minus-one (and
//! minus-two, halved, split) forms are known to these files only. A value that does not fit is an
//! error, never masked.
//!
//! ```
//! use canbaud::timing::controllers::{self, Configuration};
//! use canbaud::timing::{solve, Request};
//! use canbaud::units::{Bitrate, Hertz};
//!
//! let mcp2515 = controllers::find("mcp2515").unwrap();
//! let request = Request::new(Hertz::new(16_000_000).unwrap(), Bitrate::new(500_000).unwrap());
//! let solution = solve(&request, &mcp2515.nominal).unwrap();
//! let words: Vec<u32> = mcp2515
//!     .pack(&Configuration::classic(solution.timing))
//!     .unwrap()
//!     .map(|(_, word)| word.unwrap())
//!     .collect();
//! assert_eq!(words, [0x00, 0xA7, 0x01]); // CNF1, CNF2, CNF3: 8 + 5 + 2 TQ, SJW 1
//! ```
//!
//! The same at compile time, for a firmware:
//!
//! ```
//! use canbaud::{bit_timing, timing::controllers::{bxcan, Configuration}};
//! const BTR: u32 = match bxcan::BTR
//!     .pack(&Configuration::classic(bit_timing!(36_000_000, 500_000, bxcan::NOMINAL)))
//! {
//!     Ok(word) => word,
//!     Err(_) => panic!("the bit timing does not fit BTR"),
//! };
//! assert_eq!(BTR, 0x0005_0008); // 9 x (1 + 6 + 1)
//! ```

mod configuration;
mod controller;
mod draft;
mod error;
mod field;
mod list;
pub mod register;

pub mod an82527;
pub mod at90can;
pub mod at91;
pub mod bxcan;
pub mod c167;
pub mod c_can;
pub mod ctu_can_fd;
pub mod ds80c390;
pub mod esp32_twai;
pub mod esp32_twai_rev2;
pub mod esp32s3_twai;
pub mod flexcan_cbt;
pub mod flexcan_ctrl1;
pub mod flexcan_enhanced;
pub mod flexcan_fdcbt;
pub mod grcan;
pub mod hi3110;
pub mod ifi_canfd;
pub mod kvaser_kcan;
pub mod lpc_can;
pub mod m16c_can;
pub mod m_can;
pub mod m_can_3_0;
pub mod mcp2515;
pub mod mcp251xfd;
pub mod mscan;
pub mod multican;
pub mod nxp_canxl;
pub mod peak_pucan;
pub mod rcan;
pub mod rockchip_canfd;
pub mod rscanfd_gen3;
pub mod rscanfd_gen3_classic;
pub mod rscanfd_gen4;
pub mod sja1000;
pub mod ti_hecc;
pub mod twincan;
pub mod x_can_prt;
pub mod xcan;
pub mod xcanfd1;
pub mod xcanfd2;

pub use configuration::{Configuration, Pwm};
pub use controller::{Controller, Packed, Phase, PrescalerSharing};
pub use error::RegisterError;
pub use list::{ALL, find};
pub use register::Register;
