// The groups of a page from what the bulk pass has found in and around it.
#pragma once

#include "cut/bulk.h"
#include "cut/bulk_masks.h"

namespace fjell {

// Writes all groups of one step of a page, and the slots of their vertices; adds to BulkPage::parents. masks: gathered
// there, finer ones too. A page that is not page 0 has one step, and then all of its groups.
void write_step(Pages& pages, BulkPass& bulk, const Mesh& mesh, const BulkSquares& at, const BulkMasks& masks);

} // namespace fjell
