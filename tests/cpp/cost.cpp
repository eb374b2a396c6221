// The loop of tests/cpp/cost.c through fabric_kernel.hpp.
#include "fabric_kernel.hpp"

#include <cstdio>

constexpr int ROUNDS = 500;

extern "C" __attribute__((noinline)) double measured(fabric::Sim &sim)
{
    double sum = 0.0;
    for (int i = 0; i < ROUNDS; i++) {
        if (!sim.step())
            return -1.0;
        const auto contact = sim.contact();
        const auto projectile = sim.projectile();
        const auto time = sim.time();
        if (!contact || !projectile || !time)
            return -1.0;
        sum += contact->work + projectile->velocity[2] * time->seconds;
    }
    return sum;
}

int main()
{
    fk_scene scene = fk_scene_preset(FK_PRESET_SHEET_3IN_SPHERE);
    scene.sheet.nodes_x = scene.sheet.nodes_y = 21;
    auto sim = fabric::Sim::make(scene);
    if (!sim)
        return 1;
    std::printf("%.17g\n", measured(*sim));
    return 0;
}
