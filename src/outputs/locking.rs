//! HDF5's file locking: how a program switches it off so that readers can look during a run.

/// Environment variable that HDF5 reads when it first opens a file.
pub const FILE_LOCKING_VARIABLE: &str = "HDF5_USE_FILE_LOCKING";

/// Whether this process runs with HDF5's file locking off.
#[must_use]
pub fn file_locking_is_off() -> bool {
    std::env::var(FILE_LOCKING_VARIABLE)
        .is_ok_and(|value| value == "0" || value.eq_ignore_ascii_case("false"))
}

/// Starts the running program afresh with `HDF5_USE_FILE_LOCKING=FALSE`, in the same process.
///
/// Call it first thing in `main`, before any thread and any NetCDF call. Where the variable is
/// already set, to whatever value, nothing happens: a user's own choice stands. Otherwise the
/// process image is replaced (`exec`), with the same process number, arguments, working folder and
/// open files, at the cost of one program start (about a millisecond), and this call does not return.
///
/// Neither netCDF-C nor the `netcdf` crate hands HDF5's access properties to the caller, and setting
/// an environment variable inside a running process is not safe in Rust, hence this way.
///
/// Returns the reason where the restart failed, or on systems without `exec`; the run can then go on,
/// and readers must set the variable on their side.
pub fn restart_without_file_locking() -> Option<std::io::Error> {
    if std::env::var_os(FILE_LOCKING_VARIABLE).is_some() {
        return None;
    }
    Some(restart())
}

#[cfg(unix)]
fn restart() -> std::io::Error {
    use std::os::unix::process::CommandExt as _;
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(cause) => return cause,
    };
    let mut arguments = std::env::args_os();
    let mut command = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        command.arg0(name);
    }
    command.args(arguments).env(FILE_LOCKING_VARIABLE, "FALSE").exec()
}

#[cfg(not(unix))]
fn restart() -> std::io::Error {
    std::io::Error::new(std::io::ErrorKind::Unsupported, "this system cannot replace a running program")
}
