// All of fjell::io: packs from files, and a terrain in one object (fjell/io/live_terrain.h).
#pragma once

#include "fjell/fjell.h"
#include "fjell/io/failure.h"
#include "fjell/io/heights.h"
#include "fjell/io/journal.h"
#include "fjell/io/live_terrain.h"
#include "fjell/io/load.h"
#include "fjell/io/materials.h"
#include "fjell/io/pack_file.h"
#include "fjell/io/stream_reader.h"
