//! The floating-point environment: the host's is saved, ours set, the host's restored.
//!
//! Hosts built with fast-math flush subnormals to zero or round otherwise; the same bits then come only if every call computes
//! in one environment: round to nearest, no flushing, no traps. Status flags raised inside are hidden from the host.

/// Runs `work` with rounding to nearest and subnormals kept.
pub fn in_our_environment<R>(work: impl FnOnce() -> R) -> R {
    let _restored = Environment::enter();
    call(work)
}

/// Not inlined, so that no arithmetic moves across the change of the environment.
#[inline(never)]
fn call<R>(work: impl FnOnce() -> R) -> R {
    work()
}

/// The host's control word; put back when dropped.
struct Environment(u64);

impl Environment {
    fn enter() -> Environment {
        let host = Environment(read());
        write(OURS);
        host
    }
}

impl Drop for Environment {
    fn drop(&mut self) {
        write(self.0);
    }
}

/// MXCSR: all exceptions masked, round to nearest, no flush-to-zero, no denormals-are-zero.
#[cfg(target_arch = "x86_64")]
const OURS: u64 = 0x1f80;
/// FPCR: all off.
#[cfg(not(target_arch = "x86_64"))]
const OURS: u64 = 0;

#[cfg(target_arch = "x86_64")]
fn read() -> u64 {
    let mut word = 0_u32;
    // SAFETY: stores the 32-bit control register into a local of that size.
    unsafe { core::arch::asm!("stmxcsr [{}]", in(reg) &mut word, options(nostack, preserves_flags)) };
    u64::from(word)
}

#[cfg(target_arch = "x86_64")]
fn write(word: u64) {
    let word = word as u32;
    // SAFETY: loads the control register with a value that was read from it, or with the default one.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &word, options(nostack, readonly, preserves_flags)) };
}

#[cfg(target_arch = "aarch64")]
fn read() -> u64 {
    let word: u64;
    // SAFETY: reads the control register; no memory is touched.
    unsafe { core::arch::asm!("mrs {}, fpcr", out(reg) word, options(nostack, nomem, preserves_flags)) };
    word
}

#[cfg(target_arch = "aarch64")]
fn write(word: u64) {
    // SAFETY: writes a value that was read from the register, or 0, its default.
    unsafe { core::arch::asm!("msr fpcr, {}", in(reg) word, options(nostack, nomem, preserves_flags)) };
}

/// Other targets have no environment that a host changes.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn read() -> u64 {
    OURS
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn write(_: u64) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn the_hosts_setting_comes_back() {
        let host = read();
        write(0xffc0); // flush to zero, denormals are zero, round towards zero
        let inside = in_our_environment(read);
        let after = read();
        write(host);
        assert_eq!((inside & 0xffc0, after & 0xffc0), (0x1f80, 0xffc0));
    }
}
