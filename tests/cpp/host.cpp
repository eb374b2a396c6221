// A C++ host of libfabric_kernel: the same impact as tests/c/host.c through the same header. Prints the digest.
#include "fabric_kernel.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

namespace {

[[noreturn]] void fail(const char *call, std::int32_t status)
{
    std::fprintf(stderr, "%s: %s\n", call, fk_status_name(status));
    std::exit(1);
}

void require(const char *call, std::int32_t status)
{
    if (status != FK_OK)
        fail(call, status);
}

struct Release {
    std::align_val_t alignment;
    void operator()(void *memory) const { ::operator delete(memory, alignment); }
};

} // namespace

int main()
{
    fk_scene scene;
    require("fk_scene_preset", fk_scene_preset(&scene, sizeof scene, FK_PRESET_SHEET_3IN_SPHERE));
    scene.sheet_nodes_x = 41;
    scene.sheet_nodes_y = 41;

    std::uint64_t bytes = 0, align = 0;
    require("fk_memory_size", fk_memory_size(&scene, &bytes, &align));
    const std::align_val_t alignment{static_cast<std::size_t>(align)};
    const std::unique_ptr<void, Release> memory{::operator new(bytes, alignment), Release{alignment}};

    fk_sim *sim = nullptr;
    require("fk_init", fk_init(memory.get(), bytes, &scene, &sim, nullptr));
    require("fk_advance", fk_advance(sim, 3000));
    std::uint64_t digest = 0;
    require("fk_digest", fk_digest(sim, &digest));
    std::printf("%016llx\n", static_cast<unsigned long long>(digest));
    return 0;
}
