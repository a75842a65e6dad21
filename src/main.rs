//! The `hati` binary: a thin shell around the library.

fn main() -> std::process::ExitCode {
    // HDF5 reads its locking switch from the environment when it opens its first file
    if let Some(cause) = hati::outputs::restart_without_file_locking() {
        hati::cli::note(&format!("file locking stays on ({cause}): readers must wait until the run ends"));
    }
    hati::cli::main()
}
