// A C++ host of libfabric_kernel through fabric_kernel.hpp: the scenes of tests/digests, whose digests it prints, and what the
// header promises: who owns memory, what moves, how refusals are told. Exit code 1 on the first check that fails.
#include "fabric_kernel.hpp"

#include "../digests/scenes.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <type_traits>
#include <vector>

namespace {

#define CHECK(condition)                                                                        \
    do {                                                                                        \
        if (!(condition)) {                                                                     \
            std::fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition);  \
            std::exit(1);                                                                       \
        }                                                                                       \
    } while (0)

static_assert(!std::is_copy_constructible_v<fabric::Sim> && !std::is_copy_assignable_v<fabric::Sim>);
static_assert(std::is_nothrow_move_constructible_v<fabric::Sim> && std::is_nothrow_move_assignable_v<fabric::Sim>);
static_assert(sizeof(fabric::Status) == sizeof(std::int32_t));

fk_scene small_scene()
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.sheet.nodes_x = scene.sheet.nodes_y = 41;
    return scene;
}

fabric::Sim made(const fk_scene &scene)
{
    auto sim = fabric::Sim::make(scene);
    CHECK(sim && sim.reason().ok());
    return *std::move(sim);
}

void print(const char *name, const fabric::Sim &sim)
{
    const auto digest = sim.digest();
    CHECK(digest);
    std::printf("%s %016llx\n", name, static_cast<unsigned long long>(*digest));
}

void the_digests_of_every_scene()
{
    for (const test_scene &test : test_scenes) {
        fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
        test.change(&scene);
        CHECK(fabric::check(scene));
        fabric::Sim sim = made(scene);
        CHECK(test_run(sim.raw(), &scene, test.steps) == FK_OK);
        print(test.name, sim);
    }
    fabric::Sim sim = made(small_scene());
    CHECK(sim.advance(3000));
    print("small", sim);
}

void memory_of_the_host()
{
    const fk_scene scene = small_scene();
    const auto bytes = fabric::memory_size(scene);
    CHECK(bytes);
    std::vector<std::uint8_t> memory(*bytes + 1, 0xaa);
    std::uint8_t *start = memory.data() + 1;
    CHECK(fabric::Sim::make_in(start, *bytes - 1, scene).reason().status() == FK_SHORT_BUFFER);
    auto sim = fabric::Sim::make_in(start, *bytes, scene);
    CHECK(sim);
    CHECK(sim->advance(100));
    fabric::Sim own = made(scene);
    CHECK(own.advance(100));
    CHECK(*own.digest() == *sim->digest());
}

void moves()
{
    fabric::Sim first = made(small_scene());
    CHECK(first.advance(10));
    const std::uint64_t digest = *first.digest();
    fk_sim *const handle = first.raw();
    fabric::Sim second = std::move(first);
    CHECK(first.raw() == nullptr && second.raw() == handle);
    CHECK(first.step().status() == FK_NULL_POINTER && first.fault().status() == FK_NULL_POINTER);
    CHECK(first.contact().reason().status() == FK_NULL_POINTER);
    first = made(small_scene());
    first = std::move(second);
    CHECK(first.raw() == handle && *first.digest() == digest);
    fk_scene copy = small_scene();
    copy.seed = 99;
    std::vector<fabric::Sim> sims;
    for (int i = 0; i < 5; i++)
        sims.push_back(made(copy));
    for (fabric::Sim &sim : sims)
        CHECK(sim.step());
}

void read_outs_and_images()
{
    fabric::Sim sim = made(small_scene());
    const auto taken = sim.advance_until(FK_EXITED, 50000);
    CHECK(taken && *taken < 50000 && (sim.outcome()->mask & FK_EXITED) != 0);
    CHECK(sim.time()->steps == *taken && sim.time()->seconds > 0.0);
    CHECK(sim.projectile()->velocity[2] > 0.0 && sim.contact()->work == sim.energy()->contact_work);
    CHECK(sim.support()->total[2] > 0.0 && sim.fabric()->max_stretch > 1.0 && sim.counters()->failed_segments > 0);
    CHECK(sim.step_limits()->dt > 0.0 && (*sim.momentum_residual())[2] < 1e-9);
    const auto grid = sim.grid();
    CHECK(grid && grid->nodes_x * grid->nodes_y == 41 * 41);
    std::vector<double> nodes(3 * grid->nodes_x * grid->nodes_y), segments(grid->horizontal + grid->vertical);
    CHECK(sim.copy_positions(nodes.data(), nodes.size()) && sim.copy_velocities(nodes.data(), nodes.size()));
    CHECK(sim.copy_damage(segments.data(), segments.size()) && sim.copy_stretch(segments.data(), segments.size()));
    std::vector<std::uint8_t> image(*sim.state_size());
    CHECK(sim.save(image.data(), image.size()));
    fabric::Sim other = made(small_scene());
    CHECK(other.load(image.data(), image.size()) && *other.digest() == *sim.digest());
    CHECK(sim.reset() && sim.time()->steps == 0);
    CHECK(sim.set_external_load({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}) && sim.step());
    CHECK(sim.reset() && sim.set_largest_stretch(segments.data(), segments.size()));
    CHECK(sim.copy_positions(nodes.data(), nodes.size()));
    const std::vector<double> rest(nodes.size(), 0.0);
    CHECK(sim.set_motion(nodes.data(), rest.data(), nodes.size()) && sim.step());
}

void paths()
{
    fk_scene scene = small_scene();
    scene.drive = FK_DRIVE_PRESCRIBED;
    fabric::Sim sim = made(scene);
    fk_path path{};
    path.steps = 100;
    path.end = *sim.projectile();
    path.end.position[2] += 1e-4;
    CHECK(sim.follow(path, 100) && sim.time()->steps == 100);
    CHECK(sim.follow(path, 1).status() == FK_BAD_PATH && std::strcmp(sim.fault().data().field, "path.first") == 0);
}

void bands()
{
    fabric::Sim sim = made(small_scene()), plain = made(small_scene());
    std::vector<double> scratch(*sim.bands_size(2) / sizeof(double) + 8);
    auto *start = reinterpret_cast<char *>(scratch.data());
    const std::uint64_t bytes = *sim.bands_size(2);
    CHECK(sim.bands_begin(2, 0, start, bytes));
    CHECK(sim.step().status() == FK_BAND_OUT_OF_TURN);
    for (int pass = 0; pass < 100; pass++)
        CHECK(*sim.bands_pass(1) == 0 && *sim.bands_pass(0) == 1);
    CHECK(sim.bands_progress()->steps == 100 && sim.bands_end());
    CHECK(plain.advance(100) && *sim.digest() == *plain.digest());
}

void refusals()
{
    CHECK(fabric::check(fk_scene_preset(77)).status() == FK_STRUCT_SIZE);
    fk_scene scene = small_scene();
    scene.sheet.plies = 0;
    const fabric::Fault fault = fabric::check(scene);
    CHECK(!fault && std::strcmp(fault.data().field, "sheet.plies") == 0);
    const auto sim = fabric::Sim::make(scene);
    CHECK(!sim && sim.reason().status() == FK_OUT_OF_RANGE && std::strcmp(sim.reason().text(), fault.text()) == 0);
#ifdef __cpp_exceptions
    bool caught = false;
    try {
        fabric::Sim::make(scene).or_throw();
    } catch (const fabric::Error &error) {
        caught = error.fault().status() == FK_OUT_OF_RANGE && std::strstr(error.what(), "sheet.plies") != nullptr;
    }
    CHECK(caught);
    scene.sheet.plies = 1;
    fabric::Sim good = fabric::Sim::make(scene).or_throw();
    good.advance(10).or_throw();
    CHECK(good.time().or_throw().steps == 10);
#endif
}

} // namespace

int main()
{
    the_digests_of_every_scene();
    memory_of_the_host();
    moves();
    read_outs_and_images();
    paths();
    bands();
    refusals();
    return 0;
}
