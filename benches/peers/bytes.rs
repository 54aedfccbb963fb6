//! Peers that take one byte at a time.

/// Parser as in many firmwares. It takes one byte at a time, and returns a frame when it is complete.
pub(crate) trait Machine: Default + 'static {
    fn byte(&mut self, byte: u8) -> Option<&[u8]>;
}

/// Parser that adds up the checksum byte by byte and takes the modulo at the end of the frame. It does less than the
/// others: after a wrong checksum it does not search again.
pub(crate) struct DmcMachine {
    buf: [u8; 2048],
    len: usize,
    total: usize,
    sums: [u32; 2],
}

impl Default for DmcMachine {
    fn default() -> Self {
        let mut buf = [0; 2048];
        buf[..2].copy_from_slice(b"DF");
        Self { buf, len: 0, total: 12, sums: [0; 2] }
    }
}

impl Machine for DmcMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        const D: u32 = b'D' as u32;
        const F: u32 = b'F' as u32;
        match (self.len, byte) {
            (0 | 1, b'D') => self.len = 1,
            (1, b'F') => (self.len, self.sums) = (2, [D + F, 2 * D + F]),
            (0 | 1, _) => self.len = 0,
            _ => {
                self.buf[self.len] = byte;
                self.len += 1;
                self.sums[0] += u32::from(byte);
                self.sums[1] += self.sums[0];
                if self.len == 10 {
                    self.total = 12 + usize::from(u16::from_le_bytes([self.buf[8], byte]));
                    if self.total > self.buf.len() {
                        self.len = 0;
                    }
                } else if self.len == self.total {
                    self.len = 0;
                    return (self.sums.map(|sum| sum % 255) == [0, 0]).then(|| &self.buf[..self.total]);
                }
            }
        }
        None
    }
}

pub(crate) struct KosMachine {
    buf: [u8; 16_384],
    len: usize,
    total: usize,
}

impl Default for KosMachine {
    fn default() -> Self {
        Self { buf: [0; 16_384], len: 0, total: 6 }
    }
}

impl Machine for KosMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        self.buf[self.len] = byte;
        self.len += 1;
        match self.len {
            1 if byte != 4 => self.len = 0,
            3 => {
                self.total = usize::from(u16::from_be_bytes([self.buf[1], byte]));
                if !(6..=self.buf.len()).contains(&self.total) {
                    self.len = 0;
                }
            }
            len if len >= 6 && len == self.total => {
                self.len = 0;
                return Some(&self.buf[..len]);
            }
            _ => {}
        }
        None
    }
}

pub(crate) struct HootMachine {
    buf: [u8; 42],
    len: usize,
    total: usize,
}

impl Default for HootMachine {
    fn default() -> Self {
        Self { buf: [0; 42], len: 0, total: 10 }
    }
}

impl Machine for HootMachine {
    #[inline]
    fn byte(&mut self, byte: u8) -> Option<&[u8]> {
        self.buf[self.len] = byte;
        match (self.len, byte) {
            (0..5, 0) | (5, 0xFF) | (6..9 | 10.., _) => self.len += 1,
            // If there are more than five zeros, the last five count.
            (5, 0) => {}
            (9, _) => (self.len, self.total) = (10, 10 + usize::from(byte)),
            _ => self.len = 0,
        }
        if self.total > self.buf.len() {
            (self.len, self.total) = (0, 10);
        }
        if self.len == self.total {
            self.len = 0;
            return Some(&self.buf[..self.total]);
        }
        None
    }
}
