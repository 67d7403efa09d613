//! Pretty JSON in which an array of plain numbers stays on one line, without blanks.

use std::io::{self, Write};

use serde_json::ser::Formatter;

/// Pretty printing; line breaks inside an array wait until its first element shows what it holds.
#[derive(Debug, Default)]
pub(super) struct Layout {
    depth: usize,
    /// One entry for each open object or array.
    open: Vec<Open>,
    /// A separator that is due before the next element of an array.
    due: Option<Separator>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Open {
    /// Elements are objects, arrays or strings: one a line.
    broken: bool,
    filled: bool,
}

#[derive(Clone, Copy, Debug)]
enum Separator {
    First,
    Following,
}

impl Layout {
    fn line<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| writer.write_all(b"  "))
    }

    /// Writes the separator that is due: a line break before anything but a number.
    fn settle<W: ?Sized + Write>(&mut self, writer: &mut W, number: bool) -> io::Result<()> {
        let Some(due) = self.due.take() else { return Ok(()) };
        if let Some(open) = self.open.last_mut() {
            open.filled = true;
            open.broken |= !number;
        }
        let broken = self.open.last().is_some_and(|o| o.broken);
        if matches!(due, Separator::Following) {
            writer.write_all(b",")?;
        }
        if broken { self.line(writer) } else { Ok(()) }
    }

    fn number<W: ?Sized + Write>(&mut self, writer: &mut W, value: impl std::fmt::Display) -> io::Result<()> {
        self.settle(writer, true)?;
        write!(writer, "{value}")
    }

    fn begin<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.settle(writer, false)?;
        self.depth += 1;
        self.open.push(Open::default());
        writer.write_all(bracket)
    }

    fn end<W: ?Sized + Write>(&mut self, writer: &mut W, bracket: &[u8]) -> io::Result<()> {
        self.due = None;
        self.depth -= 1;
        if self.open.pop().is_some_and(|o| o.broken && o.filled) {
            self.line(writer)?;
        }
        writer.write_all(bracket)
    }
}

impl Formatter for Layout {
    fn write_null<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.number(writer, "null")
    }

    fn write_bool<W: ?Sized + Write>(&mut self, writer: &mut W, value: bool) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_i8<W: ?Sized + Write>(&mut self, writer: &mut W, value: i8) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_i16<W: ?Sized + Write>(&mut self, writer: &mut W, value: i16) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_i32<W: ?Sized + Write>(&mut self, writer: &mut W, value: i32) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_i64<W: ?Sized + Write>(&mut self, writer: &mut W, value: i64) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_u8<W: ?Sized + Write>(&mut self, writer: &mut W, value: u8) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_u16<W: ?Sized + Write>(&mut self, writer: &mut W, value: u16) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_u32<W: ?Sized + Write>(&mut self, writer: &mut W, value: u32) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_u64<W: ?Sized + Write>(&mut self, writer: &mut W, value: u64) -> io::Result<()> {
        self.number(writer, value)
    }

    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, value: f32) -> io::Result<()> {
        self.settle(writer, true)?;
        serde_json::ser::CompactFormatter.write_f32(writer, value)
    }

    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        self.settle(writer, true)?;
        serde_json::ser::CompactFormatter.write_f64(writer, value)
    }

    fn begin_string<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.settle(writer, false)?;
        writer.write_all(b"\"")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.begin(writer, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, _: &mut W, first: bool) -> io::Result<()> {
        self.due = Some(if first { Separator::First } else { Separator::Following });
        Ok(())
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.begin(writer, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(writer, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if let Some(open) = self.open.last_mut() {
            *open = Open { broken: true, filled: true };
        }
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }
}
