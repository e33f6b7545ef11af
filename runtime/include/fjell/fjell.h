// The whole library in one include: packs, terrains, both methods, streaming and queries. The optional libraries have
// headers of their own (fjell/io, fjell/gl, fjell/gltf). So has GLM (fjell/glm.h), which the library does not need.
// Where sizes have 32 bits (WebAssembly), a ..._bytes() function returns the largest multiple of 64 if the block would
// be larger than that. No memory has so many bytes, so creation then fails.
#pragma once

#include "fjell/asserts.h"
#include "fjell/compact.h"
#include "fjell/cut.h"
#include "fjell/edit.h"
#include "fjell/export.h"
#include "fjell/ground_maps.h"
#include "fjell/handle.h"
#include "fjell/jobs.h"
#include "fjell/measure.h"
#include "fjell/mesh.h"
#include "fjell/pack.h"
#include "fjell/pack_set.h"
#include "fjell/pages.h"
#include "fjell/query.h"
#include "fjell/recursive.h"
#include "fjell/sample_index.h"
#include "fjell/status.h"
#include "fjell/stream.h"
#include "fjell/terrain.h"
#include "fjell/texture.h"
#include "fjell/version.h"
#include "fjell/view.h"
