//! Access to the SII (the EEPROM) through registers 0500h to 050Fh (ETG.1000.4, 6.4).

use super::registers::{SII_ADDRESS, SII_CONTROL, SII_DATA, SII_OWNER};

const WRITE_ENABLE: u16 = 1 << 0;
/// Eight bytes are read at a time.
const READS_EIGHT: u16 = 1 << 6;
const COMMANDS: u16 = 7 << 8;
const READ: u16 = 1 << 8;
const WRITE: u16 = 2 << 8;
const RELOAD: u16 = 4 << 8;
const COMMAND_ERROR: u16 = 1 << 13;
const WRITE_ERROR: u16 = 1 << 14;
/// Word of the configured station alias.
pub(crate) const ALIAS_WORD: u32 = 4;

/// What a command to the SII asks of the controller beside the SII itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing.
    Nothing,
    /// The alias is taken from the SII again.
    ReloadAlias,
}

/// The SII and its port.
#[derive(Clone, Debug)]
pub(crate) struct SiiPort {
    words: Vec<u16>,
}

impl SiiPort {
    /// A port to this SII.
    pub(crate) fn new(words: Vec<u16>) -> Self {
        Self { words }
    }

    /// A word; beyond the end an erased one.
    pub(crate) fn word(&self, address: u32) -> u16 {
        usize::try_from(address).ok().and_then(|k| self.words.get(k)).copied().unwrap_or(0xFFFF)
    }

    /// Writes the alias as a maker's tool does, with the checksum over it.
    pub(crate) fn set_alias(&mut self, alias: u16) {
        const CHECKSUM_WORD: usize = 7;
        if self.words.len() > CHECKSUM_WORD {
            self.words[ALIAS_WORD as usize] = alias;
            let covered: Vec<u8> = self.words[..CHECKSUM_WORD].iter().flat_map(|w| w.to_le_bytes()).collect();
            self.words[CHECKSUM_WORD] = u16::from(crate::ethercat::sii::crc8(&covered));
        }
    }

    /// Obeys the command that was written to the control register. It is done at once: the port is never busy.
    pub(crate) fn obey(&mut self, memory: &mut [u8]) -> Effect {
        let at = usize::from(SII_CONTROL);
        let control = u16::from_le_bytes([memory[at], memory[at + 1]]);
        let address = usize::from(SII_ADDRESS);
        let word: [u8; 4] = memory[address..address + 4].try_into().expect("four bytes");
        let word = u32::from_le_bytes(word);
        let belongs_to_pdi = memory[usize::from(SII_OWNER)] & 3 == 1;
        let mut effect = Effect::Nothing;
        let mut status = READS_EIGHT;
        match control & COMMANDS {
            0 => {}
            _ if belongs_to_pdi => status |= COMMAND_ERROR,
            READ => {
                for k in 0..4 {
                    let data = usize::from(SII_DATA) + 2 * k as usize;
                    memory[data..data + 2].copy_from_slice(&self.word(word.wrapping_add(k)).to_le_bytes());
                }
            }
            WRITE if control & WRITE_ENABLE == 0 => status |= WRITE_ERROR,
            WRITE => {
                let data = usize::from(SII_DATA);
                let value = u16::from_le_bytes([memory[data], memory[data + 1]]);
                match usize::try_from(word).ok().and_then(|k| self.words.get_mut(k)) {
                    Some(found) => *found = value,
                    None => status |= WRITE_ERROR,
                }
            }
            RELOAD => effect = Effect::ReloadAlias,
            _ => status |= COMMAND_ERROR,
        }
        memory[at..at + 2].copy_from_slice(&status.to_le_bytes());
        effect
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(port: &mut SiiPort, memory: &mut [u8], control: u16, word: u32) -> u16 {
        memory[0x502..0x504].copy_from_slice(&control.to_le_bytes());
        memory[0x504..0x508].copy_from_slice(&word.to_le_bytes());
        port.obey(memory);
        u16::from_le_bytes([memory[0x502], memory[0x503]])
    }

    #[test]
    fn eight_bytes_are_read_and_an_erased_word_stands_beyond_the_end() {
        let (mut port, mut memory) = (SiiPort::new(vec![1, 2, 3, 4, 5, 6]), vec![0; 0x600]);
        assert_eq!(command(&mut port, &mut memory, 0x0100, 1), 0x0040);
        assert_eq!(memory[0x508..0x510], [2, 0, 3, 0, 4, 0, 5, 0]);
        command(&mut port, &mut memory, 0x0100, 5);
        assert_eq!(memory[0x508..0x510], [6, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]);
    }

    #[test]
    fn a_word_is_written_only_when_that_is_enabled_and_exists() {
        let (mut port, mut memory) = (SiiPort::new(vec![0; 8]), vec![0; 0x600]);
        memory[0x508..0x50A].copy_from_slice(&[0x34, 0x12]);
        assert_eq!(command(&mut port, &mut memory, 0x0200, 4) & WRITE_ERROR, WRITE_ERROR);
        assert_eq!(port.word(4), 0);
        assert_eq!(command(&mut port, &mut memory, 0x0201, 4) & WRITE_ERROR, 0);
        assert_eq!(port.word(4), 0x1234);
        assert_eq!(command(&mut port, &mut memory, 0x0201, 99) & WRITE_ERROR, WRITE_ERROR);
    }

    #[test]
    fn a_master_that_gave_the_sii_away_is_refused_and_zero_clears_the_error() {
        let (mut port, mut memory) = (SiiPort::new(vec![7; 8]), vec![0; 0x600]);
        memory[0x500] = 1;
        assert_eq!(command(&mut port, &mut memory, 0x0100, 0) & COMMAND_ERROR, COMMAND_ERROR);
        memory[0x500] = 0;
        assert_eq!(command(&mut port, &mut memory, 0x0000, 0), 0x0040);
    }
}
