//! The `edgegait` command.

fn main() -> std::process::ExitCode {
    edgegait::cli::main()
}
