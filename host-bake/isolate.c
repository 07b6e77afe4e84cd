/* A process of its own for what reads other people's files.
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

/* A crash is told by the baker, in one line: no core, no last words of C++. */
static void prepare(void)
{
    const struct rlimit none = {0, 0};
    signal(SIGALRM, SIG_DFL);
    setrlimit(RLIMIT_CORE, &none);
    if (!sanitized) {
        int nowhere = open("/dev/null", O_WRONLY);
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

static int fail_note(const isolate_job *job, const isolate_note *now, const char *what,
                     bake_error *error)
{
    return bake_fail(error, "%s:%d: '%.*s' %s", job->scene, now->line,
                     (int)strnlen(now->path, sizeof now->path - 1), now->path, what);
}

static int explain(const isolate_job *job, const isolate_note *now, int status, bake_error *error)
{
    char what[200];
    int cause = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (cause == SIGALRM) {
        snprintf(what, sizeof what,
                 "was not read within %d s; if it is not damaged, give it fewer polygons", SECONDS);
    } else if (cause == SIGKILL || (WIFEXITED(status) && WEXITSTATUS(status) != 0)) {
        snprintf(what, sizeof what,
                 "takes more than %d GB of memory to read; if it is not damaged, give it fewer "
                 "polygons or frames",
                 GIGABYTES);
    } else {
        snprintf(what, sizeof what,
                 "is damaged: the reader stopped (%s); export it again, or in another format",
                 cause ? strsignal(cause) : "what it found is nonsense");
    }
    return fail_note(job, now, what, error);
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

static int follow(const isolate_job *job, const isolate_note *now, pid_t process, FILE *from,
                  bake_error *error)
{
    int status = 0;
    error->text[0] = 0;
    int err = take(job, from, error);
    fclose(from);
    while (waitpid(process, &status, 0) < 0) { /* a signal that has a handler */
    }
    return err == 0 || error->text[0] ? err : explain(job, now, status, error);
}

int isolate(const isolate_job *job, bake_error *error)
{
    int ends[2];
    isolate_note *now =
        mmap(NULL, sizeof *now, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (now == MAP_FAILED || pipe(ends) != 0) {
        return bake_fail(error, "%s: no memory or no pipe to read files through", job->scene);
    }
    fflush(NULL); /* or what is buffered here would be written by both */
    pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        run(job, now, fdopen(ends[1], "wb"));
    }
    close(ends[1]);
    FILE *from = fdopen(ends[0], "rb");
    int err =
        process < 0
            ? bake_fail(error, "%s: no process to read files in: too many are running", job->scene)
            : follow(job, now, process, from, error);
    if (process < 0) {
        fclose(from);
    }
    munmap(now, sizeof *now);
    return err;
}
