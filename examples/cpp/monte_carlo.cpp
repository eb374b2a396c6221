// The ballistic limit V50 of a small sheet of stochastic yarn, with its confidence interval: threads, one simulation each.
//
//     ./monte_carlo [threads]
//
// At each of a ladder of velocities a dozen sheets are hit, each of its own seed. V50 is Spearman and Karber's estimate
// from the parts perforated: no model of the curve, only that the ladder reaches from no perforation to all. The result does
// not depend on the number of threads. Exit code 1 if a call is refused or fails, 2 if the ladder is too short.
#include <fabric_kernel.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t STEPS = 8, SHEETS = 12; // velocities in the ladder, sheets at each
constexpr double SLOWEST = 73.0, APART = 1.0;      // m/s

double velocity(std::size_t step) { return SLOWEST + APART * static_cast<double>(step); }

fk_scene small_sheet()
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.sheet.nodes_x = scene.sheet.nodes_y = 25;
    scene.projectile.radius = 2e-3;
    scene.projectile.mass = 2e-4;
    scene.projectile.position[2] = -scene.projectile.radius;
    scene.track_support = 0;
    return scene;
}

// One hit: true if the projectile exits, false if it is stopped.
bool perforates(fk_scene &scene, std::uint64_t seed, double velocity)
{
    scene.seed = seed;
    scene.projectile.velocity[2] = velocity;
    fabric::Sim sim = fabric::Sim::make(scene).or_throw();
    sim.advance_until(FK_ENDS, 100000).or_throw();
    return (sim.outcome().or_throw().mask & FK_EXITED) != 0;
}

// Hits until none is left. Threads share nothing but the number of the next hit; each counts what it has seen.
void work(std::atomic<std::size_t> &next, std::array<std::size_t, STEPS> &perforated)
{
    fk_scene mine = small_sheet();
    for (std::size_t hit = next++; hit < STEPS * SHEETS; hit = next++) {
        const std::size_t step = hit / SHEETS;
        perforated[step] += perforates(mine, 1 + hit, velocity(step));
    }
}

} // namespace

int main(int argc, char **argv)
{
    const unsigned here = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t threads = argc > 1 ? static_cast<std::size_t>(std::max(1, std::atoi(argv[1]))) : here;
    std::atomic<std::size_t> next{0};
    std::vector<std::array<std::size_t, STEPS>> counts(threads, std::array<std::size_t, STEPS>{});
    std::atomic<bool> failed{false};
    std::vector<std::thread> team;
    for (std::size_t t = 0; t < threads; t++) {
        team.emplace_back([&next, &failed, &mine = counts[t]] {
            try {
                work(next, mine);
            } catch (const fabric::Error &error) {
                std::fprintf(stderr, "%s\n", error.what());
                failed = true;
            }
        });
    }
    for (std::thread &thread : team)
        thread.join();
    if (failed)
        return 1;

    std::array<double, STEPS> part{};
    for (std::size_t step = 0; step < STEPS; step++) {
        std::size_t sum = 0;
        for (const auto &count : counts)
            sum += count[step];
        part[step] = static_cast<double>(sum) / SHEETS;
        std::printf("%4.0f m/s: %2zu of %zu perforated\n", velocity(step), sum, SHEETS);
    }
    if (part.front() > 0.0 || part.back() < 1.0) {
        std::fprintf(stderr, "the ladder does not reach from no to every perforation\n");
        return 2;
    }
    double v50 = 0.0, variance = 0.0;
    for (std::size_t step = 0; step + 1 < STEPS; step++)
        v50 += (part[step + 1] - part[step]) * 0.5 * (velocity(step) + velocity(step + 1));
    for (const double p : part)
        variance += APART * APART * p * (1.0 - p) / (SHEETS - 1);
    std::printf("V50 = %.2f m/s, 95 %% interval +- %.2f m/s\n", v50, 1.96 * std::sqrt(variance));
    return 0;
}
