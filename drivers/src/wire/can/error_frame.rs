//! Error frames: what the interface's own CAN controller says about the bus (Linux, `include/uapi/linux/can/error.h`).

/// Classes of an error frame.
mod class {
    pub(super) const TRANSMIT_TIMEOUT: u32 = 1 << 0;
    pub(super) const LOST_ARBITRATION: u32 = 1 << 1;
    pub(super) const CONTROLLER: u32 = 1 << 2;
    pub(super) const PROTOCOL: u32 = 1 << 3;
    pub(super) const TRANSCEIVER: u32 = 1 << 4;
    pub(super) const NO_ACKNOWLEDGE: u32 = 1 << 5;
    pub(super) const BUS_OFF: u32 = 1 << 6;
    pub(super) const BUS_ERROR: u32 = 1 << 7;
    pub(super) const RESTARTED: u32 = 1 << 8;
}

/// Byte of the details that belongs to the class "controller", and its bits.
const CONTROLLER_BYTE: usize = 1;
const OVERFLOW: u8 = 0x03;
const WARNING: u8 = 0x0C;
const PASSIVE: u8 = 0x30;
const ACTIVE: u8 = 0x40;

/// An error frame. It is made by the interface of this computer and never seen on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanErrorFrame {
    /// Classes of errors, one bit each; the flag that marks error frames is not among them.
    pub classes: u32,
    /// Details: byte 1 is the state of the controller, the others stand in the source of the kernel.
    pub detail: [u8; 8],
}

impl CanErrorFrame {
    /// An error frame that says that the controller is off the bus.
    pub const BUS_OFF: Self = Self { classes: class::BUS_OFF, detail: [0; 8] };

    /// Whether the controller went off the bus: it neither sends nor receives any more.
    pub const fn is_bus_off(&self) -> bool {
        self.classes & class::BUS_OFF != 0
    }

    /// Whether the controller was restarted after it had gone off the bus.
    pub const fn is_restarted(&self) -> bool {
        self.classes & class::RESTARTED != 0
    }

    /// Whether the controller is error passive: one of its error counters is above 127.
    pub const fn is_error_passive(&self) -> bool {
        self.controller() & PASSIVE != 0
    }

    /// Whether nobody acknowledged a frame.
    pub const fn lacks_acknowledge(&self) -> bool {
        self.classes & class::NO_ACKNOWLEDGE != 0
    }

    /// Whether frames were lost because a buffer of the controller was full.
    pub const fn has_overflow(&self) -> bool {
        self.controller() & OVERFLOW != 0
    }

    const fn controller(&self) -> u8 {
        if self.classes & class::CONTROLLER != 0 { self.detail[CONTROLLER_BYTE] } else { 0 }
    }

    /// In words: all that it says, the worst first.
    pub fn text(&self) -> String {
        let said = |class: u32| self.classes & class != 0;
        let controller = self.controller();
        let parts = [
            (self.is_bus_off(), "the CAN controller is off the bus"),
            (self.is_restarted(), "the CAN controller was restarted"),
            (self.is_error_passive(), "the CAN controller is error passive"),
            (controller & WARNING != 0, "an error counter of the CAN controller is above 95"),
            (self.has_overflow(), "a buffer of the CAN controller was full: frames were lost"),
            (controller & ACTIVE != 0, "the CAN controller is error active again"),
            (self.lacks_acknowledge(), "no other node acknowledges frames"),
            (said(class::TRANSMIT_TIMEOUT), "a frame was not sent in time"),
            (said(class::LOST_ARBITRATION), "arbitration was lost"),
            (said(class::PROTOCOL), "a frame violated the protocol"),
            (said(class::TRANSCEIVER), "the transceiver reports an error"),
            (said(class::BUS_ERROR), "an error on the bus"),
        ];
        let texts: Vec<_> = parts.into_iter().filter(|(is_said, _)| *is_said).map(|(_, text)| text).collect();
        if texts.is_empty() { format!("an error of classes {:X}h", self.classes) } else { texts.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame(classes: u32, controller: u8) -> CanErrorFrame {
        CanErrorFrame { classes, detail: [0, controller, 0, 0, 0, 0, 0, 0] }
    }

    #[test]
    fn classes_and_details_are_told_apart() {
        let bus_off = frame(0x40, 0);
        assert_eq!(bus_off, CanErrorFrame::BUS_OFF);
        assert!(bus_off.is_bus_off() && !bus_off.is_restarted() && !bus_off.is_error_passive());
        assert!(frame(0x100, 0).is_restarted());
        assert!(frame(0x04, 0x20).is_error_passive());
        assert!(!frame(0x40, 0x20).is_error_passive(), "the details belong to another class");
        assert!(frame(0x20, 0).lacks_acknowledge());
        assert!(frame(0x04, 0x01).has_overflow());
    }

    #[test]
    fn several_errors_in_one_frame_are_all_told() {
        assert_eq!(
            frame(0x24, 0x20).text(),
            "the CAN controller is error passive, no other node acknowledges frames"
        );
        assert_eq!(frame(0x04, 0x40).text(), "the CAN controller is error active again");
        assert_eq!(frame(0x200, 0).text(), "an error of classes 200h");
    }

    proptest! {
        #[test]
        fn every_error_frame_has_words(classes in any::<u32>(), detail in any::<[u8; 8]>()) {
            let text = CanErrorFrame { classes, detail }.text();
            prop_assert!(!text.is_empty());
        }
    }
}
