//! Controllers, each by a function of its own: what a firmware does not name is not linked.

use crate::status::canbaud_status;
use crate::storage::write;
use canbaud::timing::controllers::{self, Controller};
use core::ffi::{CStr, c_char};

/// A controller that canbaud knows: its limits and registers.
pub struct canbaud_controller {
    controller: &'static Controller,
}

impl canbaud_controller {
    pub(crate) const fn get(&self) -> &'static Controller {
        self.controller
    }
}

/// The controller with this name or alias ("bxcan", "FDCAN", "mcp2515"); upper and lower case, `-`
/// and `_` are the same. All controllers get linked: a firmware calls the function of its own one.
///
/// # Safety
/// `name` must be NULL or end with a zero; `controller` must be valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn canbaud_controller_find(
    name: *const c_char,
    controller: *mut *const canbaud_controller,
) -> canbaud_status {
    if name.is_null() {
        return canbaud_status::NULL_POINTER;
    }
    // SAFETY: not NULL, and the caller says that it ends with a zero.
    let name = unsafe { CStr::from_ptr(name) };
    let found = name.to_str().ok().and_then(controllers::find);
    let Some(found) = found.and_then(|found| ALL.iter().find(|c| c.controller.name == found.name))
    else {
        return canbaud_status::UNKNOWN_CONTROLLER;
    };
    // SAFETY: as the caller says.
    match unsafe { write(controller, found) } {
        Ok(()) => canbaud_status::OK,
        Err(status) => status,
    }
}

static SJA1000: canbaud_controller =
    canbaud_controller { controller: &controllers::sja1000::CONTROLLER };

/// NXP SJA1000 and 82C200. Clock: crystal (f_XTAL, divided by 2).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_sja1000() -> *const canbaud_controller {
    &SJA1000
}

static AN82527: canbaud_controller =
    canbaud_controller { controller: &controllers::an82527::CONTROLLER };

/// Intel AN82527 and Bosch CC770. Clock: SCLK (the crystal, or half of it: CPU interface register DSC).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_an82527() -> *const canbaud_controller {
    &AN82527
}

static C167: canbaud_controller = canbaud_controller { controller: &controllers::c167::CONTROLLER };

/// Infineon C167, C164 and ST10; C505CA and C515C hold the same two bytes. Clock: f_CPU (divided by 2 while CPS = 0).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_c167() -> *const canbaud_controller {
    &C167
}

static TWINCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::twincan::CONTROLLER };

/// Infineon TwinCAN (XC16x, C161CS, XC164): ABTRL, BBTRL. Clock: f_CAN (a further 8 when DIV8X is set).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_twincan() -> *const canbaud_controller {
    &TWINCAN
}

static MULTICAN: canbaud_controller =
    canbaud_controller { controller: &controllers::multican::CONTROLLER };

/// Infineon MultiCAN (XC2000, XE166, TC17xx, XMC1, XMC4). Clock: f_CAN (a further 8 when DIV8 is set).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_multican() -> *const canbaud_controller {
    &MULTICAN
}

static DS80C390: canbaud_controller =
    canbaud_controller { controller: &controllers::ds80c390::CONTROLLER };

/// Dallas DS80C390: C0BT0, C0BT1 and the prescaler bits in COR. Clock: F_OSC (divided by CCD, 2 unless told otherwise).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_ds80c390() -> *const canbaud_controller {
    &DS80C390
}

static BXCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::bxcan::CONTROLLER };

/// ST bxCAN (STM32 F0 to F4, F7, L4). Clock: APB clock (PCLK).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_bxcan() -> *const canbaud_controller {
    &BXCAN
}

static M_CAN: canbaud_controller =
    canbaud_controller { controller: &controllers::m_can::CONTROLLER };

/// Bosch M_CAN from 3.1: STM32 FDCAN, TI MCAN and TCAN4550, SAM MCAN, Infineon MCMCAN. Clock: CAN kernel clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_m_can() -> *const canbaud_controller {
    &M_CAN
}

static M_CAN_3_0: canbaud_controller =
    canbaud_controller { controller: &controllers::m_can_3_0::CONTROLLER };

/// Bosch M_CAN 3.0 (SAM V71 revision A, SAMA5D2): BTP and FBTP. Clock: CAN kernel clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_m_can_3_0() -> *const canbaud_controller {
    &M_CAN_3_0
}

static MCP2515: canbaud_controller =
    canbaud_controller { controller: &controllers::mcp2515::CONTROLLER };

/// Microchip MCP2510, MCP2515, MCP25625; PIC18 ECAN BRGCON1 to 3. Clock: crystal (F_OSC, divided by 2).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_mcp2515() -> *const canbaud_controller {
    &MCP2515
}

static MCP251XFD: canbaud_controller =
    canbaud_controller { controller: &controllers::mcp251xfd::CONTROLLER };

/// Microchip MCP2517FD, MCP2518FD; CAN FD of dsPIC33 and PIC18-Q. Clock: SYSCLK (40 MHz at most, 80 MHz on dsPIC33).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_mcp251xfd() -> *const canbaud_controller {
    &MCP251XFD
}

static FLEXCAN_CTRL1: canbaud_controller =
    canbaud_controller { controller: &controllers::flexcan_ctrl1::CONTROLLER };

/// NXP FlexCAN, CTRL1. Clock: CAN protocol engine clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_flexcan_ctrl1() -> *const canbaud_controller {
    &FLEXCAN_CTRL1
}

static FLEXCAN_CBT: canbaud_controller =
    canbaud_controller { controller: &controllers::flexcan_cbt::CONTROLLER };

/// NXP FlexCAN with CBT (BTF = 1), classic. Clock: CAN protocol engine clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_flexcan_cbt() -> *const canbaud_controller {
    &FLEXCAN_CBT
}

static FLEXCAN_FDCBT: canbaud_controller =
    canbaud_controller { controller: &controllers::flexcan_fdcbt::CONTROLLER };

/// NXP FlexCAN with CAN FD: CBT, FDCBT and FDCTRL. Clock: CAN protocol engine clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_flexcan_fdcbt() -> *const canbaud_controller {
    &FLEXCAN_FDCBT
}

static FLEXCAN_ENHANCED: canbaud_controller =
    canbaud_controller { controller: &controllers::flexcan_enhanced::CONTROLLER };

/// NXP FlexCAN with enhanced bit timing (CTRL2.BTE = 1). Clock: CAN protocol engine clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_flexcan_enhanced() -> *const canbaud_controller {
    &FLEXCAN_ENHANCED
}

static NXP_CANXL: canbaud_controller =
    canbaud_controller { controller: &controllers::nxp_canxl::CONTROLLER };

/// NXP S32Z2 CANXL_SIC. Clock: CAN protocol engine clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_nxp_canxl() -> *const canbaud_controller {
    &NXP_CANXL
}

static X_CAN_PRT: canbaud_controller =
    canbaud_controller { controller: &controllers::x_can_prt::CONTROLLER };

/// Bosch X_CAN protocol unit (CAN XL). Clock: CAN clock (80 or 160 MHz for CAN XL).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_x_can_prt() -> *const canbaud_controller {
    &X_CAN_PRT
}

static ESP32_TWAI: canbaud_controller =
    canbaud_controller { controller: &controllers::esp32_twai::CONTROLLER };

/// Espressif TWAI of the ESP32. Clock: APB clock (80 MHz).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_esp32_twai() -> *const canbaud_controller {
    &ESP32_TWAI
}

static ESP32S3_TWAI: canbaud_controller =
    canbaud_controller { controller: &controllers::esp32s3_twai::CONTROLLER };

/// Espressif TWAI of ESP32-S2, S3, C3, C6 and H2. Clock: APB clock (80 MHz; C6: 40 MHz, H2: 32 MHz crystal).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_esp32s3_twai() -> *const canbaud_controller {
    &ESP32S3_TWAI
}

static ESP32_TWAI_REV2: canbaud_controller =
    canbaud_controller { controller: &controllers::esp32_twai_rev2::CONTROLLER };

/// Espressif TWAI of the ESP32 from chip revision 2, with BRP_DIV. Clock: APB clock (80 MHz).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_esp32_twai_rev2() -> *const canbaud_controller {
    &ESP32_TWAI_REV2
}

static CTU_CAN_FD: canbaud_controller =
    canbaud_controller { controller: &controllers::ctu_can_fd::CONTROLLER };

/// CTU CAN FD (also ESP32-C5 TWAI-FD). Clock: core clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_ctu_can_fd() -> *const canbaud_controller {
    &CTU_CAN_FD
}

static XCAN: canbaud_controller = canbaud_controller { controller: &controllers::xcan::CONTROLLER };

/// Xilinx AXI CAN, Zynq-7000, ZynqMP. Clock: CAN reference clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_xcan() -> *const canbaud_controller {
    &XCAN
}

static XCANFD1: canbaud_controller =
    canbaud_controller { controller: &controllers::xcanfd1::CONTROLLER };

/// Xilinx CAN FD 1.0. Clock: CAN clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_xcanfd1() -> *const canbaud_controller {
    &XCANFD1
}

static XCANFD2: canbaud_controller =
    canbaud_controller { controller: &controllers::xcanfd2::CONTROLLER };

/// Xilinx and AMD CAN FD 2.0 (Versal). Clock: CAN clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_xcanfd2() -> *const canbaud_controller {
    &XCANFD2
}

static AT91: canbaud_controller = canbaud_controller { controller: &controllers::at91::CONTROLLER };

/// Atmel AT91 and SAMA5D3 CAN. Clock: MCK.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_at91() -> *const canbaud_controller {
    &AT91
}

static TI_HECC: canbaud_controller =
    canbaud_controller { controller: &controllers::ti_hecc::CONTROLLER };

/// TI HECC and eCAN. Clock: module clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_ti_hecc() -> *const canbaud_controller {
    &TI_HECC
}

static C_CAN: canbaud_controller =
    canbaud_controller { controller: &controllers::c_can::CONTROLLER };

/// Bosch C_CAN and D_CAN (LPC11C, LPC43, TM4C, AM335x, TMS320F28x, Cyclone V). Clock: module clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_c_can() -> *const canbaud_controller {
    &C_CAN
}

static RCAN: canbaud_controller = canbaud_controller { controller: &controllers::rcan::CONTROLLER };

/// Renesas R-Car CAN, RX and RA CAN: BCR. Clock: PCLK or CANMCLK (bit CCLKS).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_rcan() -> *const canbaud_controller {
    &RCAN
}

static RSCANFD_GEN3: canbaud_controller =
    canbaud_controller { controller: &controllers::rscanfd_gen3::CONTROLLER };

/// Renesas RS-CANFD, generation 3 (RZ/G2L, R-Car 3), FD mode. Clock: DLL clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_rscanfd_gen3() -> *const canbaud_controller {
    &RSCANFD_GEN3
}

static RSCANFD_GEN3_CLASSIC: canbaud_controller =
    canbaud_controller { controller: &controllers::rscanfd_gen3_classic::CONTROLLER };

/// Renesas RS-CANFD, generation 3, classic mode. Clock: DLL clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_rscanfd_gen3_classic() -> *const canbaud_controller {
    &RSCANFD_GEN3_CLASSIC
}

static RSCANFD_GEN4: canbaud_controller =
    canbaud_controller { controller: &controllers::rscanfd_gen4::CONTROLLER };

/// Renesas RS-CANFD, generation 4 (R-Car 4). Clock: DLL clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_rscanfd_gen4() -> *const canbaud_controller {
    &RSCANFD_GEN4
}

static LPC_CAN: canbaud_controller =
    canbaud_controller { controller: &controllers::lpc_can::CONTROLLER };

/// NXP LPC17xx, LPC21xx, LPC23xx, LPC40xx; Allwinner sun4i. Clock: PCLK.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_lpc_can() -> *const canbaud_controller {
    &LPC_CAN
}

static AT90CAN: canbaud_controller =
    canbaud_controller { controller: &controllers::at90can::CONTROLLER };

/// Atmel AT90CAN32/64/128, ATmega16M1/32M1/64M1. Clock: clkIO.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_at90can() -> *const canbaud_controller {
    &AT90CAN
}

static MSCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::mscan::CONTROLLER };

/// Freescale MSCAN. Clock: bus or oscillator clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_mscan() -> *const canbaud_controller {
    &MSCAN
}

static HI3110: canbaud_controller =
    canbaud_controller { controller: &controllers::hi3110::CONTROLLER };

/// Holt HI-3110. Clock: oscillator.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_hi3110() -> *const canbaud_controller {
    &HI3110
}

static GRCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::grcan::CONTROLLER };

/// Cobham GRCAN: CONF. Clock: system clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_grcan() -> *const canbaud_controller {
    &GRCAN
}

static IFI_CANFD: canbaud_controller =
    canbaud_controller { controller: &controllers::ifi_canfd::CONTROLLER };

/// IFI CAN FD. Clock: core clock.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_ifi_canfd() -> *const canbaud_controller {
    &IFI_CANFD
}

static KVASER_KCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::kvaser_kcan::CONTROLLER };

/// Kvaser KCAN (PCIEcan). Clock: 80 MHz.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_kvaser_kcan() -> *const canbaud_controller {
    &KVASER_KCAN
}

static ROCKCHIP_CANFD: canbaud_controller =
    canbaud_controller { controller: &controllers::rockchip_canfd::CONTROLLER };

/// Rockchip RK3568 CAN FD. Clock: CAN clock (300 MHz; the prescaler counts in twos).
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_rockchip_canfd() -> *const canbaud_controller {
    &ROCKCHIP_CANFD
}

static M16C_CAN: canbaud_controller =
    canbaud_controller { controller: &controllers::m16c_can::CONTROLLER };

/// Renesas M16C and M32C 16-slot CAN. Clock: f_CAN.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_m16c_can() -> *const canbaud_controller {
    &M16C_CAN
}

static PEAK_PUCAN: canbaud_controller =
    canbaud_controller { controller: &controllers::peak_pucan::CONTROLLER };

/// PEAK uCAN (PCAN-USB FD, PCIe FD). Clock: 20, 24, 30, 40, 60 or 80 MHz, chosen with the timing.
#[unsafe(no_mangle)]
pub extern "C" fn canbaud_controller_peak_pucan() -> *const canbaud_controller {
    &PEAK_PUCAN
}

/// All of them, in the order of the library.
static ALL: [canbaud_controller; 41] = [
    canbaud_controller { controller: &controllers::sja1000::CONTROLLER },
    canbaud_controller { controller: &controllers::an82527::CONTROLLER },
    canbaud_controller { controller: &controllers::c167::CONTROLLER },
    canbaud_controller { controller: &controllers::twincan::CONTROLLER },
    canbaud_controller { controller: &controllers::multican::CONTROLLER },
    canbaud_controller { controller: &controllers::ds80c390::CONTROLLER },
    canbaud_controller { controller: &controllers::bxcan::CONTROLLER },
    canbaud_controller { controller: &controllers::m_can::CONTROLLER },
    canbaud_controller { controller: &controllers::m_can_3_0::CONTROLLER },
    canbaud_controller { controller: &controllers::mcp2515::CONTROLLER },
    canbaud_controller { controller: &controllers::mcp251xfd::CONTROLLER },
    canbaud_controller { controller: &controllers::flexcan_ctrl1::CONTROLLER },
    canbaud_controller { controller: &controllers::flexcan_cbt::CONTROLLER },
    canbaud_controller { controller: &controllers::flexcan_fdcbt::CONTROLLER },
    canbaud_controller { controller: &controllers::flexcan_enhanced::CONTROLLER },
    canbaud_controller { controller: &controllers::nxp_canxl::CONTROLLER },
    canbaud_controller { controller: &controllers::x_can_prt::CONTROLLER },
    canbaud_controller { controller: &controllers::esp32_twai::CONTROLLER },
    canbaud_controller { controller: &controllers::esp32s3_twai::CONTROLLER },
    canbaud_controller { controller: &controllers::esp32_twai_rev2::CONTROLLER },
    canbaud_controller { controller: &controllers::ctu_can_fd::CONTROLLER },
    canbaud_controller { controller: &controllers::xcan::CONTROLLER },
    canbaud_controller { controller: &controllers::xcanfd1::CONTROLLER },
    canbaud_controller { controller: &controllers::xcanfd2::CONTROLLER },
    canbaud_controller { controller: &controllers::at91::CONTROLLER },
    canbaud_controller { controller: &controllers::ti_hecc::CONTROLLER },
    canbaud_controller { controller: &controllers::c_can::CONTROLLER },
    canbaud_controller { controller: &controllers::rcan::CONTROLLER },
    canbaud_controller { controller: &controllers::rscanfd_gen3::CONTROLLER },
    canbaud_controller { controller: &controllers::rscanfd_gen3_classic::CONTROLLER },
    canbaud_controller { controller: &controllers::rscanfd_gen4::CONTROLLER },
    canbaud_controller { controller: &controllers::lpc_can::CONTROLLER },
    canbaud_controller { controller: &controllers::at90can::CONTROLLER },
    canbaud_controller { controller: &controllers::mscan::CONTROLLER },
    canbaud_controller { controller: &controllers::hi3110::CONTROLLER },
    canbaud_controller { controller: &controllers::grcan::CONTROLLER },
    canbaud_controller { controller: &controllers::ifi_canfd::CONTROLLER },
    canbaud_controller { controller: &controllers::kvaser_kcan::CONTROLLER },
    canbaud_controller { controller: &controllers::rockchip_canfd::CONTROLLER },
    canbaud_controller { controller: &controllers::m16c_can::CONTROLLER },
    canbaud_controller { controller: &controllers::peak_pucan::CONTROLLER },
];
