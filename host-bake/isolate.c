/* A process of its own for what takes other people's data.
 * Source: own.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "isolate.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/* For one file; and beside what the baker has when the process starts. The largest motion that is
 * read takes 1.6 GB of doubles, and a part of that twice. */
#define SECONDS   60
#define GIGABYTES 4

/* The address sanitizer maps more than any limit, and looks for leaks at exit. */
#ifdef __SANITIZE_ADDRESS__
static const int sanitized = 1;
#else
static const int sanitized = 0;
#endif

static const isolate_words reading = {
    .before = "'",
    .after = "'",
    .verb = "read",
    .past = "read",
    .stopped = "is damaged: the reader stopped",
    .slow_try = "if it is not damaged, give it fewer polygons",
    .large_try = "if it is not damaged, give it fewer polygons or frames",
    .stopped_try = "export it again, or in another format",
};

void isolate_now(isolate_note *now, int line, const char *path)
{
    now->line = line;
    snprintf(now->path, sizeof now->path, "%s", path);
    alarm(SECONDS);
}

void isolate_complaint(const char *text)
{
    if (strstr(text, "bad_alloc") != NULL || strstr(text, "length_error") != NULL) {
        _exit(EXIT_FAILURE);
    }
}

void *isolate_get(FILE *from, size_t count, size_t size)
{
    void *data = bake_alloc(count, size);
    if (fread(data, size, count, from) == count) {
        return data;
    }
    free(data);
    return NULL;
}

/* ---- in the process --------------------------------------------------------------------------- */

/* Never more than the baker itself may have. */
static void limit_memory(void)
{
    unsigned long pages = 0;
    struct rlimit memory;
    FILE *statm = fopen("/proc/self/statm", "r");
    int known = statm != NULL && fscanf(statm, "%lu", &pages) == 1;
    rlim_t most = pages * (rlim_t)sysconf(_SC_PAGESIZE) + ((rlim_t)GIGABYTES << 30);
    if (known && getrlimit(RLIMIT_AS, &memory) == 0 && memory.rlim_cur > most) {
        memory.rlim_cur = most;
        setrlimit(RLIMIT_AS, &memory);
    }
    if (statm != NULL) {
        fclose(statm);
    }
}

/* A crash is told by the baker, in one line: no core, no last words of C++. What a library prints is
 * not the baker's answer. */
static void prepare(void)
{
    const struct rlimit none = {0, 0};
    int nowhere = open("/dev/null", O_WRONLY);
    signal(SIGALRM, SIG_DFL);
    setrlimit(RLIMIT_CORE, &none);
    dup2(nowhere, STDOUT_FILENO);
    if (!sanitized) {
        dup2(nowhere, STDERR_FILENO);
        limit_memory();
    }
}

static void run(const isolate_job *job, isolate_note *now, FILE *to)
{
    bake_error error = {""};
    int err;
    prepare();
    err = job->read(job->what, now, &error);
    alarm(0);
    fwrite(&err, sizeof err, 1, to);
    if (err == 0) {
        job->send(job->what, to);
    } else {
        fwrite(error.text, sizeof error.text, 1, to);
    }
    err = fclose(to);
    if (sanitized) {
        exit(err != 0);
    }
    _exit(err != 0);
}

/* ---- in the baker ----------------------------------------------------------------------------- */

static int explain(const char *scene, const isolate_words *words, const isolate_note *now,
                   int status, bake_error *error)
{
    char what[400];
    int cause = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (cause == SIGALRM) {
        snprintf(what, sizeof what, "was not %s within %d s; %s", words->past, SECONDS,
                 words->slow_try);
    } else if (cause == SIGKILL || (WIFEXITED(status) && WEXITSTATUS(status) != 0)) {
        snprintf(what, sizeof what, "takes more than %d GB of memory to %s; %s", GIGABYTES,
                 words->verb, words->large_try);
    } else {
        snprintf(what, sizeof what, "%s (%s); %s", words->stopped,
                 cause ? strsignal(cause) : "what it found is nonsense", words->stopped_try);
    }
    return bake_fail(error, "%s:%d: %s%.*s%s %s", scene, now->line, words->before,
                     (int)strnlen(now->path, sizeof now->path - 1), now->path, words->after, what);
}

/* Readers quote what they have found in a file: nothing of that may steer a terminal. */
static void clean(char *text)
{
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] == '\n') {
        text[--length] = 0;
    }
    for (; *text; text++) {
        *text = (unsigned char)*text < ' ' || *text == 127 ? '?' : *text;
    }
}

/* 0, or -1: with the process' own message if it sent one. */
static int take(const isolate_job *job, FILE *from, bake_error *error)
{
    int err = -1;
    if (fread(&err, sizeof err, 1, from) != 1) {
        return -1;
    }
    if (err == 0) {
        return job->take(job->what, from);
    }
    if (fread(error->text, sizeof error->text, 1, from) != 1) {
        error->text[0] = 0;
    }
    error->text[sizeof error->text - 1] = 0;
    clean(error->text);
    return -1;
}

typedef struct {
    pid_t process;
    FILE *from;
} running;

/* 0, or -1; what the process did if it did not say why. */
static int follow(const isolate_job *job, const running *r, int *status, bake_error *error)
{
    error->text[0] = 0;
    int err = take(job, r->from, error);
    fclose(r->from);
    while (waitpid(r->process, status, 0) < 0) { /* a signal that has a handler */
    }
    return err;
}

int isolate_as(const isolate_job *job, const isolate_words *words, bake_error *error)
{
    int ends[2], status = 0;
    isolate_note *now =
        mmap(NULL, sizeof *now, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (now == MAP_FAILED || pipe(ends) != 0) {
        return bake_fail(error, "%s: no memory or no pipe to read files through", job->scene);
    }
    fflush(NULL); /* or what is buffered here would be written by both */
    running r = {.process = fork()};
    if (r.process == 0) {
        close(ends[0]);
        run(job, now, fdopen(ends[1], "wb"));
    }
    close(ends[1]);
    r.from = fdopen(ends[0], "rb");
    int err;
    if (r.process < 0) {
        fclose(r.from);
        err = bake_fail(error, "%s: no process to read files in: too many are running", job->scene);
    } else {
        err = follow(job, &r, &status, error);
        if (err != 0 && error->text[0] == 0) {
            explain(job->scene, words, now, status, error);
        }
    }
    munmap(now, sizeof *now);
    return err;
}

int isolate(const isolate_job *job, bake_error *error)
{
    return isolate_as(job, &reading, error);
}
