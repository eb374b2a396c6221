//! The floating-point environment: the host's is saved, ours set, the host's restored.
//!
//! Hosts built with fast-math flush subnormals to zero or round otherwise; the same bits then come only if
//! every call computes in one environment: round to nearest, no flushing, no traps. Status flags raised
//! inside are hidden from the host.
//!
//! That is done where the compiler tells that there is such a control word: on x86 with SSE2, x86-64, AArch64
//! and hard-float Arm. WebAssembly and floating point in software round to nearest only. On other processors
//! (RISC-V) the host must leave it at that.

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
        write(host.0 & KEPT | OURS);
        host
    }
}

impl Drop for Environment {
    fn drop(&mut self) {
        write(self.0);
    }
}

/// MXCSR: all exceptions masked, round to nearest, no flush-to-zero, no denormals-are-zero.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
const OURS: u64 = 0x1f80;
/// FPCR, FPSCR: all off.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
const OURS: u64 = 0;

/// Bits that the host keeps inside, too: of FPSCR the three that say how loops end or how long vectors are,
/// not how to round.
const KEPT: u64 = if cfg!(target_arch = "arm") { 7 << 16 } else { 0 };

// With SSE2 the x87 does no arithmetic. It only loads, stores and converts 64-bit integers: exact up to 2^53,
// however it rounds.
#[cfg(any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse2")))]
fn read() -> u64 {
    let mut word = 0_u32;
    // SAFETY: stores the 32-bit control register into a local of that size.
    unsafe { core::arch::asm!("stmxcsr [{}]", in(reg) &mut word, options(nostack, preserves_flags)) };
    u64::from(word)
}

#[cfg(any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse2")))]
fn write(word: u64) {
    let word = word as u32;
    // SAFETY: reads a local of the register's size. Its value was read from the register, is the default, or
    // sets only bits that every processor with SSE2 has; a reserved bit would be a fault.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &word, options(nostack, readonly)) };
}

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
fn read() -> u64 {
    let word: u32;
    // SAFETY: reads the control register, which every processor with this calling convention has; no memory
    // is touched.
    unsafe { core::arch::asm!("vmrs {}, fpscr", out(reg) word, options(nostack, nomem, preserves_flags)) };
    u64::from(word)
}

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
fn write(word: u64) {
    let word = word as u32;
    // SAFETY: writes a value that was read from the register, or the same with everything but KEPT off.
    unsafe { core::arch::asm!("vmsr fpscr, {}", in(reg) word, options(nostack, nomem)) };
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

/// The others: see the top.
#[cfg(not(any(
    target_arch = "x86_64",
    all(target_arch = "x86", target_feature = "sse2"),
    target_arch = "aarch64",
    all(target_arch = "arm", target_abi = "eabihf")
)))]
fn read() -> u64 {
    OURS
}

#[cfg(not(any(
    target_arch = "x86_64",
    all(target_arch = "x86", target_feature = "sse2"),
    target_arch = "aarch64",
    all(target_arch = "arm", target_abi = "eabihf")
)))]
fn write(_: u64) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(any(target_arch = "x86_64", all(target_arch = "x86", target_feature = "sse2")))]
    fn the_hosts_setting_comes_back() {
        let host = read();
        write(0xffc0); // flush to zero, denormals are zero, round towards zero
        let inside = in_our_environment(read);
        let after = read();
        write(host);
        assert_eq!((inside & 0xffc0, after & 0xffc0), (0x1f80, 0xffc0));
    }
}
