//! Prints the table of points per wavelength, `sem/src/solid/dispersion.csv`:
//! `cargo run --release -p hati-sem --example dispersion_table > sem/src/solid/dispersion.csv`
#![allow(clippy::print_stdout, reason = "its output is its purpose")]

fn main() -> Result<(), hati_sem::SemError> {
    print!("{}", hati_sem::solid::dispersion::table()?);
    Ok(())
}
