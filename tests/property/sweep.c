#define _DEFAULT_SOURCE
#include "sweep.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#define MAX_WORKERS 64
#define POLL_US 20000

// Shared by all processes; the results follow.
typedef struct {
    atomic_int next;
} progress_t;

#define HEADER 64 // keeps the results aligned

static void* memory;
static size_t memory_size;

int sweep_count(int quick, int full) { return getenv("SSV_LONG") == NULL ? quick : full; }

static progress_t* share(size_t size) {
    if (memory != NULL) munmap(memory, memory_size);
    memory_size = HEADER + size;
    memory = mmap(NULL, memory_size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) memory = NULL;
    return memory;
}

static void show(const char* name, int done, int count) {
    if (!isatty(STDERR_FILENO)) return;
    fprintf(stderr, "\r%s: %d of %d%s", name, done < count ? done : count, count, done < count ? "" : "\n");
}

void* sweep(const char* name, int count, size_t size, void (*run)(int k, void* result)) {
    progress_t* progress = share((size_t)count * size);
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const int workers = cores < 1 ? 1 : cores > MAX_WORKERS ? MAX_WORKERS : (int)cores;
    pid_t worker[MAX_WORKERS];
    bool whole = true;
    if (progress == NULL) return NULL;
    (void)fflush(NULL); // or each process would print what is pending
    for (int w = 0; w < workers; w++) {
        worker[w] = fork();
        if (worker[w] != 0) continue;
        for (int k = atomic_fetch_add(&progress->next, 1); k < count; k = atomic_fetch_add(&progress->next, 1)) {
            run(k, (char*)memory + HEADER + (size_t)k * size);
        }
        _exit(EXIT_SUCCESS);
    }
    for (int w = 0; w < workers; w++) {
        int status = -1; // did not exit
        while (worker[w] > 0 && waitpid(worker[w], &status, WNOHANG) == 0) {
            show(name, atomic_load(&progress->next), count);
            usleep(POLL_US);
        }
        whole = whole && WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS;
    }
    show(name, count, count);
    return whole ? (char*)memory + HEADER : NULL;
}

static int compare(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double sweep_quantile(double* value, int count, double q) {
    qsort(value, (size_t)count, sizeof *value, compare);
    return value[(int)(q * (count - 1))];
}
