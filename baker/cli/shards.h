// The commands around shards: plan, shard, launch, merge. Each returns the program's exit code.
#pragma once

#include "baker/cli/arguments.h"

namespace fjell::baker {

int run_plan(const Arguments& arguments);
int run_shard(const Arguments& arguments);
int run_launch(const Arguments& arguments);
int run_merge(const Arguments& arguments);

} // namespace fjell::baker
