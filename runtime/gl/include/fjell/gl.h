// All of fjell::gl, the OpenGL renderer (fjell/gl/renderer.h).
#pragma once

#include "fjell/gl/context.h"
#include "fjell/gl/ground_colour.h"
#include "fjell/gl/image.h"
#include "fjell/gl/layers.h"
#include "fjell/gl/light.h"
#include "fjell/gl/lines.h"
#include "fjell/gl/palette.h"
#include "fjell/gl/renderer.h"
#include "fjell/gl/target.h"
