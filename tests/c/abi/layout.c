/* Compiles only if the header's structures are those of layout.inc and scene.inc; C11 or later, C++17 or later. Nothing to run. */
#include "fabric_kernel.h"

#include <stddef.h>

#ifdef __cplusplus
#define HOLDS static_assert
#else
#define HOLDS _Static_assert
#endif

#define SIZE(structure, bytes) HOLDS(sizeof(structure) == bytes, #structure " has another size");
#define FIELD(structure, field, at, bytes)                                                       \
    HOLDS(offsetof(structure, field) == at, #structure "." #field " is elsewhere");              \
    HOLDS(sizeof(((structure *)0)->field) == bytes, #structure "." #field " has another size");
#define REAL(member, at, bytes) FIELD(fk_scene, member, at, bytes)
#define WHOLE(member, at, bytes) FIELD(fk_scene, member, at, bytes)
#include "layout.inc"
#include "scene.inc"
