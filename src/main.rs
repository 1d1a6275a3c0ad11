//! The `twinlight` command: see `twinlight --help`.

use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's memory; where there is no more, and nobody bears that, the command says so and ends with code 1 instead of aborting.
struct OrExit;

fn checked(pointer: *mut u8, bytes: usize) -> *mut u8 {
    if pointer.is_null() && !twinlight::backend::bears_refusal() {
        static SAID: AtomicBool = AtomicBool::new(false);
        if SAID.swap(true, Ordering::Relaxed) {
            // Another thread ends the command.
            loop {
                std::thread::park();
            }
        }
        // Without allocating; a closed standard error changes nothing.
        let _ = writeln!(
            std::io::stderr(),
            "error: out of memory: {bytes} bytes more are needed; use a smaller size or resolution"
        );
        std::process::exit(1);
    }
    pointer
}

// SAFETY: every call goes to the system's allocator as it is; its results are returned unless they are null.
unsafe impl GlobalAlloc for OrExit {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are those that `System` asks for.
        checked(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        checked(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        checked(unsafe { System.realloc(pointer, layout, size) }, size)
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static MEMORY: OrExit = OrExit;

fn main() -> ExitCode {
    twinlight::cli::main()
}
