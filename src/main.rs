//! The `twinlight` command: see `twinlight --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    twinlight::cli::main()
}
