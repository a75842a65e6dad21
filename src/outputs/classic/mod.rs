//! A classic NetCDF file that grows by whole rows and is valid at every instant, whatever ends the run.
//!
//! HDF5 (NetCDF-4) keeps its index in blocks all over the file, and a process that is killed while it
//! flushes can leave a file that does not open. A classic file has one number that tells how many rows
//! there are, and the rows lie behind each other. So a row is written behind the last one, and
//! [`ClassicFile::sync`] first brings the rows to the disk and then raises the number, four (eight) bytes:
//! a reader, and whoever comes after a kill or a power cut, sees whole rows only. To cut a file back is to
//! lower the number and the file's length. The price is that the file is not compressed while it grows;
//! [`super::compress`] does that once it is complete.

mod header;

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

pub(super) use header::{Attribute, Kind, Layout, Places, Variable};

use super::OutputError;
use super::error::{Unresumable, expect_room, folder_of};

/// Bytes of rows that are written together.
const WRITTEN_TOGETHER: usize = 1 << 16;
/// Bytes of a header at most; a file of hati's has some kilobytes.
const LONGEST_HEADER: u64 = 1 << 24;

/// A value as the file stores it.
pub(super) trait Value: Copy {
    /// Its type.
    const KIND: Kind;
    /// Writes it big-endian into a slice of its size.
    fn put(self, to: &mut [u8]);
}

macro_rules! value {
    ($type:ty, $kind:ident) => {
        impl Value for $type {
            const KIND: Kind = Kind::$kind;
            fn put(self, to: &mut [u8]) {
                to.copy_from_slice(&self.to_be_bytes());
            }
        }
    };
}
value!(i8, Byte);
value!(u8, Char);
value!(i32, Int);
value!(f32, Float);
value!(f64, Double);

/// A file open for writing.
#[derive(Debug)]
pub(super) struct ClassicFile {
    file: File,
    path: PathBuf,
    layout: Layout,
    places: Places,
    /// Rows taken; the last ones may still wait.
    rows: u64,
    /// Rows that the file tells of.
    told: u64,
    /// Rows that wait to be written; never longer than its first capacity.
    waiting: Vec<u8>,
}

impl ClassicFile {
    /// Creates `path` with a layout; `fill` writes what does not grow.
    ///
    /// The file is made aside and takes its name when it is whole, so that there is never half a head under
    /// that name, and a reader of an older run keeps its file.
    pub(super) fn create(
        path: &Path,
        layout: Layout,
        fill: impl FnOnce(&mut Self) -> Result<(), OutputError>,
    ) -> Result<Self, OutputError> {
        let folder = folder_of(path);
        if !folder.is_dir() {
            let cause = std::io::Error::from(std::io::ErrorKind::NotFound);
            return Err(OutputError::UnwritableFolder { folder, cause });
        }
        let (header, places) = layout.encode();
        expect_room(path, places.rows_begin / 2)?;
        let aside = aside(path);
        let made = (|| -> std::io::Result<File> {
            let mut file =
                OpenOptions::new().read(true).write(true).create(true).truncate(true).open(&aside)?;
            file.write_all(&header)?;
            Ok(file)
        })();
        let file = made.map_err(|cause| OutputError::from_io(path, cause))?;
        let waiting = Vec::with_capacity(places.row_bytes as usize + WRITTEN_TOGETHER);
        let mut made = Self { file, path: path.to_path_buf(), layout, places, rows: 0, told: 0, waiting };
        let outcome = made.fill_missing().and_then(|()| fill(&mut made)).and_then(|()| {
            let named = made.file.sync_all().and_then(|()| std::fs::rename(&aside, path));
            named.map_err(|cause| OutputError::from_io(path, cause))
        });
        if let Err(error) = outcome {
            let _ = std::fs::remove_file(&aside);
            return Err(error);
        }
        Ok(made)
    }

    /// Opens a file that an earlier run left, cuts it back to `rows` rows and goes on with it.
    ///
    /// Errors: a file that is missing, of another layout than `expected` (dimensions and variables; its
    /// global attributes stay as they are), finished and compressed already, or with fewer rows.
    pub(super) fn open_existing(path: &Path, expected: &Layout, rows: usize) -> Result<Self, OutputError> {
        let io = |cause| OutputError::from_io(path, cause);
        let refused = |why| OutputError::Unresumable { path: path.to_path_buf(), why };
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io)?;
        let mut head = vec![];
        (&mut file).take(LONGEST_HEADER).read_to_end(&mut head).map_err(io)?;
        if head.starts_with(b"\x89HDF") {
            return Err(refused(Unresumable::Finished));
        }
        let (layout, places, told) = Layout::decode(&head).ok_or_else(|| refused(Unresumable::Unreadable))?;
        if let Some(what) = difference(&layout, expected) {
            return Err(refused(Unresumable::OtherLayout { what }));
        }
        if told < rows as u64 {
            return Err(refused(Unresumable::TooShort { found: told, expected: rows as u64 }));
        }
        let waiting = Vec::with_capacity(places.row_bytes as usize + WRITTEN_TOGETHER);
        let path = path.to_path_buf();
        let mut opened = Self { file, path, layout, places, rows: rows as u64, told, waiting };
        opened.cut()?;
        Ok(opened)
    }

    /// Lowers the number of rows first, then takes their bytes away.
    fn cut(&mut self) -> Result<(), OutputError> {
        let path = self.path.clone();
        let length = self.places.rows_begin + self.rows * self.places.row_bytes;
        let cut = self.tell().and_then(|()| self.file.sync_data()).and_then(|()| self.file.set_len(length));
        cut.map_err(|cause| OutputError::from_io(&path, cause))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Rows taken, those included that a reader does not see yet.
    pub(super) fn rows(&self) -> usize {
        self.rows as usize
    }

    /// Writes a whole variable that does not grow.
    pub(super) fn put<T: Value>(&mut self, name: &str, values: &[T]) -> Result<(), OutputError> {
        let Some(index) = self.layout.variables.iter().position(|v| v.name == name && v.kind == T::KIND)
        else {
            return Err(self.length(name, values.len(), 0));
        };
        let expected = self.layout.values(&self.layout.variables[index]);
        if values.len() != expected || self.layout.is_row(&self.layout.variables[index]) {
            return Err(self.length(name, values.len(), expected));
        }
        let mut bytes = vec![];
        extend(&mut bytes, values);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        self.write_at(self.places.begins[index], &bytes)
    }

    /// Fills what may stay missing, so that it reads as missing.
    fn fill_missing(&mut self) -> Result<(), OutputError> {
        let is_missing = |v: &&Variable| v.attributes.iter().any(|(name, _)| name == "_FillValue");
        let fixed = self.layout.variables.iter().filter(|v| !self.layout.is_row(v)).filter(is_missing);
        let fixed: Vec<(String, usize)> = fixed.map(|v| (v.name.clone(), self.layout.values(v))).collect();
        fixed.iter().try_for_each(|(name, values)| self.put(name, &vec![f32::NAN; *values]))
    }

    /// Appends a row: `doubles` for the variables of 64-bit floats, `floats` for those of 32-bit floats, each
    /// in the order of the layout. Allocates nothing. A reader sees it after the next [`Self::sync`].
    pub(super) fn append(&mut self, doubles: &[f64], floats: &[f32]) -> Result<(), OutputError> {
        let row_bytes = self.places.row_bytes as usize;
        let found = size_of_val(doubles) + size_of_val(floats);
        if found != row_bytes {
            return Err(self.length("a row in bytes", found, row_bytes));
        }
        extend(&mut self.waiting, doubles);
        extend(&mut self.waiting, floats);
        self.rows += 1;
        if self.waiting.len() >= WRITTEN_TOGETHER { self.write_waiting() } else { Ok(()) }
    }

    /// Writes the rows that wait behind those of the file.
    fn write_waiting(&mut self) -> Result<(), OutputError> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        expect_room(&self.path, self.waiting.len() as u64)?;
        let count = self.waiting.len() as u64 / self.places.row_bytes;
        let at = self.places.rows_begin + (self.rows - count) * self.places.row_bytes;
        let mut waiting = std::mem::take(&mut self.waiting);
        let outcome = self.write_at(at, &waiting);
        waiting.clear();
        self.waiting = waiting;
        outcome
    }

    fn write_at(&mut self, at: u64, bytes: &[u8]) -> Result<(), OutputError> {
        let written = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.write_all(bytes));
        written.map_err(|cause| OutputError::from_io(&self.path, cause))
    }

    fn length(&self, variable: &str, found: usize, expected: usize) -> OutputError {
        OutputError::Length { path: self.path.clone(), variable: variable.to_owned(), found, expected }
    }

    /// Brings all rows to the disk, then tells of them.
    pub(super) fn sync(&mut self) -> Result<(), OutputError> {
        if self.told == self.rows {
            return Ok(());
        }
        self.write_waiting()?;
        let path = self.path.clone();
        let synced = self.file.sync_data().and_then(|()| self.tell()).and_then(|()| self.file.sync_data());
        synced.map_err(|cause| OutputError::from_io(&path, cause))
    }

    fn tell(&mut self) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(4))?;
        self.file.write_all(&self.places.row_count(self.rows))?;
        self.told = self.rows;
        Ok(())
    }

    /// Reads `count` values of a 32-bit (8-bit, 64-bit) variable as they stand in the file, big-endian;
    /// `row` is ignored for one that does not grow.
    pub(super) fn read(&mut self, variable: usize, row: usize, to: &mut Vec<u8>) -> Result<(), OutputError> {
        let found = &self.layout.variables[variable];
        let bytes = self.layout.values(found) * found.kind.bytes();
        let skip = if self.layout.is_row(found) { row as u64 * self.places.row_bytes } else { 0 };
        let from = to.len();
        to.resize(from + bytes, 0);
        let at = SeekFrom::Start(self.places.begins[variable] + skip);
        let read = self.file.seek(at).and_then(|_| self.file.read_exact(&mut to[from..]));
        read.map_err(|cause| OutputError::from_io(&self.path, cause))
    }
}

/// The name under which a file is made before it is whole.
pub(crate) fn aside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    folder_of(path).join(format!(".{name}.part"))
}

fn extend<T: Value>(bytes: &mut Vec<u8>, values: &[T]) {
    let from = bytes.len();
    bytes.resize(from + size_of_val(values), 0);
    let slots = bytes[from..].chunks_exact_mut(size_of::<T>());
    slots.zip(values).for_each(|(slot, value)| value.put(slot));
}

/// What is not the same in two layouts, or `None`.
fn difference(found: &Layout, expected: &Layout) -> Option<String> {
    if let Some((name, length)) = expected.dimensions.iter().find(|d| !found.dimensions.contains(d)) {
        return Some(format!("dimension {name} of length {length}"));
    }
    let shape = |v: &Variable| (v.name.clone(), v.kind, v.dimensions.clone());
    let same = |a: &Variable, b: Option<&Variable>| b.is_some_and(|b| shape(a) == shape(b));
    for (number, variable) in expected.variables.iter().enumerate() {
        if !same(variable, found.variables.get(number)) {
            return Some(format!("variable {}", variable.name));
        }
    }
    found.variables.get(expected.variables.len()).map(|v| format!("no variable {}", v.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: usize = 5;

    fn layout() -> Layout {
        let variable = |name: &str, kind, dimensions: &[usize]| Variable {
            name: name.into(),
            kind,
            dimensions: dimensions.to_vec(),
            attributes: vec![],
        };
        Layout {
            dimensions: vec![("time".into(), 0), ("node".into(), NODES)],
            attributes: vec![("title".into(), "rows".into())],
            variables: vec![
                variable("x", Kind::Float, &[1]),
                variable("time", Kind::Double, &[0]),
                variable("u", Kind::Float, &[0, 1]),
            ],
        }
    }

    fn row(number: usize) -> Vec<f32> {
        (0..NODES).map(|node| (10 * number + node) as f32).collect()
    }

    fn create(path: &Path) -> ClassicFile {
        let x: Vec<f32> = (0..NODES).map(|n| n as f32).collect();
        ClassicFile::create(path, layout(), |file| file.put("x", &x)).expect("a file")
    }

    /// What a reader finds: the times and the values.
    fn read(path: &Path) -> (Vec<f64>, Vec<f32>) {
        let file = netcdf::open(path).expect("the file opens");
        let times = file.variable("time").expect("time").get_values(..).expect("values");
        (times, file.variable("u").expect("u").get_values(..).expect("values"))
    }

    fn expect_rows(path: &Path, rows: usize) {
        let (times, values) = read(path);
        assert_eq!(times, (0..rows).map(|n| n as f64).collect::<Vec<_>>());
        assert_eq!(values, (0..rows).flat_map(row).collect::<Vec<_>>());
    }

    #[test]
    fn rows_count_when_they_are_on_the_disk() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.nc");
        let mut file = create(&path);
        for number in 0..7 {
            file.append(&[number as f64], &row(number)).expect("a row");
            // Every second row is synced; the file as it is now is what a kill leaves.
            if number % 2 == 1 {
                file.sync().expect("sync");
            }
            expect_rows(&path, number + number % 2);
        }
        assert_eq!(file.rows(), 7);
        file.sync().expect("sync");
        expect_rows(&path, 7);
    }

    /// Whatever part of a row was written, and whatever rows lie behind the number, a reader sees neither.
    #[test]
    fn a_file_cut_anywhere_in_a_row_is_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.nc");
        let mut file = create(&path);
        for number in 0..2 {
            file.append(&[number as f64], &row(number)).expect("a row");
        }
        file.sync().expect("sync");
        file.append(&[2.0], &row(2)).expect("a row");
        file.write_waiting().expect("written, not told");
        let whole = std::fs::read(&path).expect("bytes");
        let row_bytes = 8 + 4 * NODES;
        for cut in 0..=row_bytes {
            let copy = folder.path().join("cut.nc");
            std::fs::write(&copy, &whole[..whole.len() - cut]).expect("copy");
            expect_rows(&copy, 2);
        }
    }

    #[test]
    fn a_restart_cuts_back_and_goes_on() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.nc");
        let mut file = create(&path);
        for number in 0..9 {
            file.append(&[number as f64 + 100.0], &row(0)).expect("a row that is not kept");
        }
        file.sync().expect("sync");
        drop(file);
        let mut file = ClassicFile::open_existing(&path, &layout(), 0).expect("opened");
        assert_eq!(read(&path).0.len(), 0);
        for number in 0..4 {
            file.append(&[number as f64], &row(number)).expect("a row");
        }
        file.sync().expect("sync");
        drop(file);
        let mut file = ClassicFile::open_existing(&path, &layout(), 3).expect("opened");
        expect_rows(&path, 3);
        file.append(&[3.0], &row(3)).expect("a row");
        file.sync().expect("sync");
        expect_rows(&path, 4);
    }

    #[test]
    fn what_cannot_be_gone_on_with_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("rows.nc");
        let mut file = create(&path);
        file.append(&[0.0], &row(0)).expect("a row");
        file.sync().expect("sync");
        let text = |layout: &Layout, rows| {
            ClassicFile::open_existing(&path, layout, rows).expect_err("refused").to_string()
        };
        assert!(text(&layout(), 2).contains("1 rows where 2"), "{}", text(&layout(), 2));
        let mut other = layout();
        other.variables[2].name = "v".into();
        assert!(text(&other, 1).contains("variable v"), "{}", text(&other, 1));
        other = layout();
        other.dimensions[1].1 = 6;
        assert!(text(&other, 1).contains("dimension node of length 6"), "{}", text(&other, 1));
        std::fs::write(&path, b"CDF\x02 nothing").expect("write");
        assert!(text(&layout(), 0).contains("no file that hati wrote"), "{}", text(&layout(), 0));
    }

    #[test]
    fn a_row_takes_no_allocation() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut file = create(&folder.path().join("rows.nc"));
        let values = row(0);
        file.append(&[0.0], &values).expect("a row");
        let counted = allocation_counter::measure(|| {
            for number in 1..50 {
                file.append(&[f64::from(number)], &values).expect("a row");
            }
        });
        assert_eq!(counted.count_total, 0, "{counted:?}");
    }
}
