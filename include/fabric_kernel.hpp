// fabric_kernel.hpp - the C interface of fabric_kernel.h for C++17: header only, nothing to link beyond the C library.
//
//     fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
//     scene.projectile.velocity[2] = 80.0;
//     auto sim = fabric::Sim::make(scene).or_throw();
//     sim.advance_until(FK_ENDS, 50000).or_throw();
//     std::printf("%.1f m/s\n", sim.projectile().or_throw().velocity[2]);
//
// Fields, constants and their documentation are those of fabric_kernel.h. What this header adds:
//
// - fabric::Sim, move-only. It owns its memory (Sim::make, one allocation) or uses the host's (Sim::make_in, none). Moving a Sim
//   moves its handle; the memory stays where it is.
// - Results instead of out-parameters. A Result holds a value or says why there is none; `if (!result)` looks, `*result` takes
//   the value, `.or_throw()` takes it or throws fabric::Error. Nothing throws unless asked to with or_throw(), which does not
//   exist where exceptions are switched off.
// - No cost: every function is one call of the C function of the same name. Every member function's errors, thread rules and
//   effects are those of that function.
#ifndef FABRIC_KERNEL_HPP
#define FABRIC_KERNEL_HPP

#include "fabric_kernel.h"

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

#if defined(__cpp_exceptions) || defined(__EXCEPTIONS) || defined(_CPPUNWIND)
#define FABRIC_HAS_EXCEPTIONS 1
#include <exception>
#endif

namespace fabric {

// Why a request was refused, in full: number, field, value, limit and a line for a log. FK_OK: it was not.
class [[nodiscard]] Fault {
public:
    Fault() noexcept = default;

    explicit Fault(std::int32_t status, const char *text) noexcept
    {
        data_.status = status;
        std::strncpy(data_.text, text, sizeof data_.text - 1);
    }

    bool ok() const noexcept { return data_.status == FK_OK; }
    explicit operator bool() const noexcept { return ok(); }
    // The status number, FK_...
    std::int32_t status() const noexcept { return data_.status; }
    // One line for a log.
    const char *text() const noexcept { return data_.text; }
    // The rest: field, value, limit.
    const fk_fault &data() const noexcept { return data_; }
    // For fk_ functions that fill a fault.
    fk_fault *raw() noexcept { return &data_; }

#ifdef FABRIC_HAS_EXCEPTIONS
    void or_throw() const;
#endif

private:
    fk_fault data_{};
};

// What a call returned: FK_OK or the number of an error. As large as the number.
class [[nodiscard]] Status {
public:
    constexpr Status() noexcept = default;
    constexpr explicit Status(std::int32_t status) noexcept : status_(status) {}

    constexpr bool ok() const noexcept { return status_ == FK_OK; }
    constexpr explicit operator bool() const noexcept { return ok(); }
    constexpr std::int32_t status() const noexcept { return status_; }
    // What the number means; Sim::fault() says more.
    const char *text() const noexcept { return fk_status_name(status_); }

#ifdef FABRIC_HAS_EXCEPTIONS
    void or_throw() const;
#endif

private:
    std::int32_t status_ = FK_OK;
};

#ifdef FABRIC_HAS_EXCEPTIONS
// Thrown by or_throw() and by nothing else.
class Error : public std::exception {
public:
    explicit Error(const Fault &fault) noexcept : fault_(fault) {}
    const char *what() const noexcept override { return fault_.text(); }
    const Fault &fault() const noexcept { return fault_; }

private:
    Fault fault_;
};

inline void Fault::or_throw() const
{
    if (!ok())
        throw Error(*this);
}

inline void Status::or_throw() const
{
    if (!ok())
        throw Error(Fault(status_, text()));
}
#endif

// A value, or the reason why there is none (a Status or a Fault).
template <class T, class Reason = Status>
class [[nodiscard]] Result {
public:
    Result() noexcept = default;
    explicit Result(Reason reason) noexcept : reason_(reason) {}
    explicit Result(T &&value) noexcept : value_(std::move(value)) {}

    bool ok() const noexcept { return reason_.ok(); }
    explicit operator bool() const noexcept { return ok(); }
    const Reason &reason() const noexcept { return reason_; }

    // The value; only if ok().
    T &operator*() &noexcept { return assert(ok()), value_; }
    const T &operator*() const &noexcept { return assert(ok()), value_; }
    T &&operator*() &&noexcept { return assert(ok()), std::move(value_); }
    T *operator->() noexcept { return assert(ok()), &value_; }
    const T *operator->() const noexcept { return assert(ok()), &value_; }

#ifdef FABRIC_HAS_EXCEPTIONS
    // The value; throws Error if there is none.
    T or_throw() &&
    {
        reason_.or_throw();
        return std::move(value_);
    }
#endif

private:
    friend class Sim;
    friend Result<std::uint64_t> memory_size(const fk_scene &scene) noexcept;
    T value_{};
    Reason reason_{};
};

// Step count, and time in s.
struct Time {
    std::uint64_t steps;
    double seconds;
};

// How far bands have come since they began, and the outcomes latched so far.
struct BandsProgress {
    std::uint64_t passes;
    std::uint64_t steps;
    std::uint32_t outcomes;
};

// fk_scene_check
inline Fault check(const fk_scene &scene) noexcept
{
    Fault fault;
    fk_scene_check(&scene, fault.raw(), sizeof(fk_fault));
    return fault;
}

// Makes the sheet of a scene that of a textile. fk_scene_set_textile
inline Fault set_textile(fk_scene &scene, const fk_textile &textile) noexcept
{
    Fault fault;
    fk_scene_set_textile(&scene, &textile, sizeof textile, fault.raw(), sizeof(fk_fault));
    return fault;
}

// Makes the fabric of the last plies that of a textile. fk_scene_set_back_textile
inline Fault set_back_textile(fk_scene &scene, const fk_textile &textile) noexcept
{
    Fault fault;
    fk_scene_set_back_textile(&scene, &textile, sizeof textile, fault.raw(), sizeof(fk_fault));
    return fault;
}

// Chooses a graded network for an error wanted. fk_scene_set_grading
inline Fault set_grading(fk_scene &scene, double error) noexcept
{
    Fault fault;
    fk_scene_set_grading(&scene, error, fault.raw(), sizeof(fk_fault));
    return fault;
}

// Bytes of a simulation's memory. fk_memory_size
inline Result<std::uint64_t> memory_size(const fk_scene &scene) noexcept
{
    Result<std::uint64_t> bytes;
    bytes.reason_ = Status(fk_memory_size(&scene, &bytes.value_));
    return bytes;
}

// A simulation. An empty one (moved from) refuses every call with FK_NULL_POINTER.
class Sim {
public:
    // Makes a simulation on memory of its own.
    static Result<Sim, Fault> make(const fk_scene &scene) noexcept
    {
        const Result<std::uint64_t> bytes = memory_size(scene);
        if (!bytes) {
            Fault why = check(scene);
            return Result<Sim, Fault>(why.ok() ? Fault(bytes.reason().status(), bytes.reason().text()) : why);
        }
        std::unique_ptr<std::byte[]> memory(new (std::nothrow) std::byte[static_cast<std::size_t>(*bytes)]);
        if (memory == nullptr)
            return Result<Sim, Fault>(Fault(FK_SHORT_BUFFER, "memory: the host has none left"));
        Result<Sim, Fault> made = make_in(memory.get(), *bytes, scene);
        made.value_.memory_ = std::move(memory);
        return made;
    }

    // Makes a simulation on the host's memory, which must stay where it is and outlive it. fk_init
    static Result<Sim, Fault> make_in(void *memory, std::uint64_t bytes, const fk_scene &scene) noexcept
    {
        Result<Sim, Fault> made;
        fk_init(memory, bytes, &scene, &made.value_.sim_, made.reason_.raw(), sizeof(fk_fault));
        return made;
    }

    Sim(Sim &&other) noexcept : memory_(std::move(other.memory_)), sim_(std::exchange(other.sim_, nullptr)) {}
    Sim &operator=(Sim &&other) noexcept
    {
        memory_ = std::move(other.memory_);
        sim_ = std::exchange(other.sim_, nullptr);
        return *this;
    }
    Sim(const Sim &) = delete;
    Sim &operator=(const Sim &) = delete;
    ~Sim() = default;

    // For functions of fabric_kernel.h.
    fk_sim *raw() const noexcept { return sim_; }

    Status reset() noexcept { return Status(fk_reset(sim_)); }
    Status step() noexcept { return Status(fk_step(sim_)); }
    Status advance(std::uint64_t steps) noexcept { return Status(fk_advance(sim_, steps)); }
    Status follow(const fk_path &path, std::uint64_t steps) noexcept { return Status(fk_follow(sim_, &path, sizeof path, steps)); }

    // The steps taken.
    Result<std::uint64_t> advance_until(std::uint32_t mask, std::uint64_t steps) noexcept
    {
        Result<std::uint64_t> taken;
        taken.reason_ = Status(fk_advance_until(sim_, mask, steps, &taken.value_));
        return taken;
    }

    // Bands: one simulation on several threads of the host's. Between begin and end only pass and progress are allowed, and
    // these from any thread. docs/embedding.md, "Lent threads"
    Result<std::uint64_t> bands_size(std::uint32_t of) const noexcept
    {
        Result<std::uint64_t> bytes;
        bytes.reason_ = Status(fk_bands_size(sim_, of, &bytes.value_));
        return bytes;
    }
    Status bands_begin(std::uint32_t of, std::uint64_t steps, void *scratch, std::uint64_t bytes) noexcept
    {
        return Status(fk_bands_begin(sim_, of, steps, scratch, bytes));
    }
    // 1 in the call that completes the pass for all bands.
    Result<std::uint32_t> bands_pass(std::uint32_t band) const noexcept
    {
        Result<std::uint32_t> last;
        last.reason_ = Status(fk_bands_pass(sim_, band, &last.value_));
        return last;
    }
    Result<BandsProgress> bands_progress() const noexcept
    {
        Result<BandsProgress> progress;
        BandsProgress &value = progress.value_;
        progress.reason_ = Status(fk_bands_progress(sim_, &value.passes, &value.steps, &value.outcomes));
        return progress;
    }
    Status bands_end() noexcept { return Status(fk_bands_end(sim_)); }

    Status set_external_load(const std::array<double, 3> &force, const std::array<double, 3> &torque) noexcept
    {
        return Status(fk_set_external_load(sim_, force.data(), torque.data()));
    }
    // n numbers at each pointer.
    Status set_motion(const double *positions, const double *velocities, std::size_t n) noexcept
    {
        return Status(fk_set_motion(sim_, positions, velocities, n));
    }
    Status set_largest_stretch(const double *stretches, std::size_t n) noexcept
    {
        return Status(fk_set_largest_stretch(sim_, stretches, n));
    }

    Result<Time> time() const noexcept
    {
        Result<Time> time;
        time.reason_ = Status(fk_get_time(sim_, &time.value_.steps, &time.value_.seconds));
        return time;
    }
    Result<std::array<double, 3>> momentum_residual() const noexcept
    {
        Result<std::array<double, 3>> residual;
        residual.reason_ = Status(fk_get_momentum_residual(sim_, residual.value_.data()));
        return residual;
    }
    Result<fk_step_limits> step_limits() const noexcept { return read(fk_get_step_limits); }
    Result<fk_grid> grid() const noexcept { return read(fk_get_grid); }
    Result<fk_motion> projectile() const noexcept { return read(fk_get_projectile); }
    Result<fk_contact> contact() const noexcept { return read(fk_get_contact); }
    Result<fk_support> support() const noexcept { return read(fk_get_support); }
    Result<fk_energy> energy() const noexcept { return read(fk_get_energy); }
    Result<fk_ply> ply(std::uint32_t number) const noexcept
    {
        Result<fk_ply> ply;
        ply.reason_ = Status(fk_get_ply(sim_, number, &ply.value_, sizeof(fk_ply)));
        return ply;
    }
    Result<fk_slip> slip(double thickness, double friction, double adhesion = 0.0) const noexcept
    {
        Result<fk_slip> slip;
        slip.reason_ = Status(fk_get_slip(sim_, thickness, friction, adhesion, &slip.value_, sizeof(fk_slip)));
        return slip;
    }
    // Uses the simulation's scratch: not beside other calls.
    Result<fk_fabric> fabric() noexcept
    {
        Result<fk_fabric> fabric;
        fabric.reason_ = Status(fk_get_fabric(sim_, &fabric.value_, sizeof(fk_fabric)));
        return fabric;
    }
    Result<fk_counters> counters() const noexcept { return read(fk_get_counters); }
    Result<fk_outcome> outcome() const noexcept { return read(fk_get_outcome); }

    // Why the last call that changes this simulation was refused or failed. fk_get_fault
    Fault fault() const noexcept
    {
        Fault fault;
        const std::int32_t status = fk_get_fault(sim_, fault.raw(), sizeof(fk_fault));
        return status == FK_OK ? fault : Fault(status, fk_status_name(status));
    }

    Status copy_positions(double *out, std::size_t n) const noexcept { return Status(fk_copy_positions(sim_, out, n)); }
    Status copy_velocities(double *out, std::size_t n) const noexcept { return Status(fk_copy_velocities(sim_, out, n)); }
    Status copy_damage(double *out, std::size_t n) const noexcept { return Status(fk_copy_damage(sim_, out, n)); }
    Status copy_stretch(double *out, std::size_t n) const noexcept { return Status(fk_copy_stretch(sim_, out, n)); }

    // Bytes of an image. fk_state_size
    Result<std::uint64_t> state_size() const noexcept
    {
        Result<std::uint64_t> bytes;
        bytes.reason_ = Status(fk_state_size(sim_, &bytes.value_));
        return bytes;
    }
    Status save(std::uint8_t *image, std::size_t bytes) const noexcept { return Status(fk_state_save(sim_, image, bytes)); }
    Status load(const std::uint8_t *image, std::size_t bytes) noexcept { return Status(fk_state_load(sim_, image, bytes)); }

    Status capsule_begin(void *memory, std::size_t bytes, std::uint64_t stride) noexcept { return Status(fk_capsule_begin(sim_, memory, bytes, stride)); }
    // `used` is set also where the memory was full.
    Status capsule_take(std::uint64_t &used) noexcept { return Status(fk_capsule_take(sim_, &used)); }
    Status capsule_end(std::uint64_t &used) noexcept { return Status(fk_capsule_end(sim_, &used)); }
    Status replay(const std::uint8_t *capsule, std::size_t bytes, std::uint64_t steps, double *room, std::size_t n, fk_replayed &replayed) noexcept
    {
        return Status(fk_replay(sim_, capsule, bytes, steps, room, n, &replayed, sizeof replayed));
    }

    Result<std::uint64_t> digest() const noexcept
    {
        Result<std::uint64_t> digest;
        digest.reason_ = Status(fk_digest(sim_, &digest.value_));
        return digest;
    }

private:
    template <class, class>
    friend class Result;
    Sim() noexcept = default;

    template <class T>
    Result<T> read(std::int32_t (*get)(const fk_sim *, T *, std::uint64_t)) const noexcept
    {
        Result<T> out;
        out.reason_ = Status(get(sim_, &out.value_, sizeof(T)));
        return out;
    }

    // Empty if the memory is the host's.
    std::unique_ptr<std::byte[]> memory_;
    fk_sim *sim_ = nullptr;
};

} // namespace fabric

#undef FABRIC_HAS_EXCEPTIONS
#endif // FABRIC_KERNEL_HPP
