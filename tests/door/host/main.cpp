#include "engine.h"

int main(int argc, char** argv) {
    return argc == 2 ? play(argv[1]) : 2;
}
