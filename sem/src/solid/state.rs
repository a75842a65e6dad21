//! A solid's state as raw bytes, so that a checkpoint needs no second copy of it in memory.

use super::{Real, Solid};
use crate::aligned::Aligned;
use std::io::{Error, ErrorKind, Read, Result, Write};

/// First bytes of a state.
const MAGIC: &[u8; 8] = b"hatisol1";

impl<T: Real> Solid<T> {
    /// Writes everything that [`Self::read_state`] needs to go on bit for bit: positions, velocities, memory variables,
    /// books and the number of steps, in the machine's own order of bytes. Multipliers are not part of it.
    ///
    /// The order of the numbers is that of the machine's vectors, so a state belongs to machines of one width; it does
    /// not depend on the number of threads.
    pub fn write_state(&self, to: &mut impl Write) -> Result<()> {
        to.write_all(MAGIC)?;
        for word in self.shape() {
            to.write_all(&word.to_ne_bytes())?;
        }
        to.write_all(&self.step.to_ne_bytes())?;
        let books = [self.books.input, self.books.outflow];
        let viscous = self.block_books.iter().map(|b| b.viscous);
        for value in books.into_iter().chain(viscous) {
            to.write_all(&value.to_ne_bytes())?;
        }
        for part in [&self.x, &self.v, &self.dashpots] {
            to.write_all(bytemuck::cast_slice(part))?;
        }
        Ok(())
    }

    /// Takes back what [`Self::write_state`] wrote of a solid made from the same ground with the same step.
    ///
    /// Errors: those of reading; [`ErrorKind::InvalidData`] where the state is of another precision, width or size. The
    /// solid is then not to be used.
    pub fn read_state(&mut self, from: &mut impl Read) -> Result<()> {
        let mut magic = [0; 8];
        from.read_exact(&mut magic)?;
        let mut shape = [0; 7];
        for value in &mut shape {
            *value = word(from)?;
        }
        let expected = self.shape();
        if magic != *MAGIC || shape != expected {
            let text = format!(
                "the state is that of another solid or of a machine with other vectors: bytes of a number, lanes, \
                 numbers and blocks are {shape:?}, expected {expected:?}"
            );
            return Err(Error::new(ErrorKind::InvalidData, text));
        }
        self.step = word(from)?;
        self.books.input = f64::from_bits(word(from)?);
        self.books.outflow = f64::from_bits(word(from)?);
        for books in &mut self.block_books {
            books.viscous = f64::from_bits(word(from)?);
        }
        for part in [&mut self.x, &mut self.v, &mut self.dashpots] {
            read_numbers(from, part)?;
        }
        Ok(())
    }

    /// Bytes that [`Self::write_state`] writes.
    pub fn state_bytes(&self) -> usize {
        let numbers = self.x.len() + self.v.len() + self.dashpots.len();
        8 * (11 + self.block_books.len()) + numbers * size_of::<T>()
    }

    /// What two solids must share for a state to fit both.
    fn shape(&self) -> [u64; 7] {
        let lengths = [self.x.len(), self.v.len(), self.dashpots.len(), self.block_books.len()];
        let step = self.dt.to_bits();
        let [x, v, dashpots, blocks] = lengths.map(|n| n as u64);
        [size_of::<T>() as u64, self.model.layout.lanes as u64, x, v, dashpots, blocks, step]
    }
}

fn word(from: &mut impl Read) -> Result<u64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    Ok(u64::from_ne_bytes(bytes))
}

fn read_numbers<T: Real>(from: &mut impl Read, to: &mut Aligned<T>) -> Result<()> {
    from.read_exact(bytemuck::cast_slice_mut(&mut to[..]))
}
