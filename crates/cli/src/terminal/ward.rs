//! A command that another one started ends when that one does, however it ended.

use std::io::Read;
use std::process::{Command, Stdio, exit};
use std::thread;

/// Set for a command whose standard input is held open by the one that started it.
const MARK: &str = "BSDFKIT_WARD";

/// Status of a command whose starter is gone.
const ORPHANED: i32 = 130;

/// Makes `command` end with this process; what [`Command::spawn`] gives has to be kept, as its standard input tells.
pub(crate) fn bind(command: &mut Command) -> &mut Command {
    command.env(MARK, "1").stdin(Stdio::piped())
}

/// In the command that was started: waits in a thread of its own for the end of the other one. Killed, that one says nothing, but its
/// end of the pipe closes.
pub(crate) fn begin() {
    if std::env::var_os(MARK).is_none() {
        return;
    }
    thread::spawn(|| {
        let mut rest = [0_u8; 64];
        let mut input = std::io::stdin().lock();
        while !matches!(input.read(&mut rest), Ok(0) | Err(_)) {}
        exit(ORPHANED);
    });
}
