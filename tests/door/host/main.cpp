#include "engine.h"

#ifdef TWO
#include <thread>

__attribute__((visibility("default"))) int play_too(const char* pack); // the same of the other engine
#endif

int main(int argc, char** argv) {
    if (argc != 2) return 2;
#ifdef TWO // side by side, and each says what one alone says
    int codes[2] = {};
    std::thread other([&] { codes[1] = play_too(argv[1]); });
    codes[0] = play(argv[1]);
    other.join();
    return codes[0] != 0 ? codes[0] : codes[1];
#else
    return play(argv[1]);
#endif
}
