// mesh_file.h - the triangles of a file, read by assimp in a process of its own. Host only; link
// with -lassimp. SPDX-License-Identifier: MIT
//
// assimp 5.2 does not survive every broken file: some truncated PLY files crash it, with others it
// asks for memory without end. So it reads in a child, which sends vertices and triangles through a
// pipe and whose memory and time have limits that grow with the file. Whatever becomes of the
// child, the parent goes on and has a line to say.
#ifndef MESH_FILE_H
#define MESH_FILE_H

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define MESH_FILE_REASON 200

// All meshes of the file in one, y up: they may be parts of one body.
typedef struct mesh_file {
    uint64_t vertices, triangles;
    float *xyz;
    uint32_t *corner;
    char reason[MESH_FILE_REASON]; // empty, or why nothing was read
} mesh_file;

static inline void mesh_file_free(mesh_file *f) {
    free(f->xyz);
    free(f->corner);
}

// ---- The child

static inline int mesh_file_send(FILE *to, const void *data, size_t size, size_t count) {
    return fwrite(data, size, count, to) == count;
}

static inline int mesh_file_send_part(FILE *to, const struct aiMesh *part, int z_up) {
    int good = 1;
    for (unsigned i = 0; good && i < part->mNumVertices; i++) {
        const struct aiVector3D p = part->mVertices[i];
        const float at[3] = {p.x, z_up ? p.z : p.y, z_up ? -p.y : p.z};
        good = mesh_file_send(to, at, sizeof *at, 3);
    }
    return good;
}

static inline int mesh_file_send_faces(FILE *to, const struct aiMesh *part, uint32_t first) {
    int good = 1;
    for (unsigned i = 0; good && i < part->mNumFaces; i++) {
        const unsigned *index = part->mFaces[i].mIndices;
        if (part->mFaces[i].mNumIndices != 3) continue; // points and lines
        const uint32_t corner[3] = {first + index[0], first + index[1], first + index[2]};
        good = mesh_file_send(to, corner, sizeof *corner, 3);
    }
    return good;
}

// The reason, the two counts, then vertices and triangles.
static inline int mesh_file_send_all(FILE *to, const char *path, int z_up) {
    mesh_file f;
    const struct aiScene *in =
        aiImportFile(path, aiProcess_Triangulate | aiProcess_PreTransformVertices);
    memset(&f, 0, sizeof f);
    if (!in) snprintf(f.reason, sizeof f.reason, "%s", aiGetErrorString());
    if (!in && !f.reason[0]) snprintf(f.reason, sizeof f.reason, "assimp does not say why");
    f.reason[strcspn(f.reason, "\r\n")] = '\0';
    for (unsigned i = 0; in && i < in->mNumMeshes; i++) {
        f.vertices += in->mMeshes[i]->mNumVertices;
        for (unsigned k = 0; k < in->mMeshes[i]->mNumFaces; k++)
            f.triangles += in->mMeshes[i]->mFaces[k].mNumIndices == 3;
    }
    if (f.vertices > UINT32_MAX)
        snprintf(f.reason, sizeof f.reason, "more vertices than 32 bits can count");
    int good = mesh_file_send(to, f.reason, 1, sizeof f.reason) &&
               mesh_file_send(to, &f.vertices, sizeof f.vertices, 1) &&
               mesh_file_send(to, &f.triangles, sizeof f.triangles, 1);
    if (f.reason[0]) return good;
    uint32_t first = 0;
    for (unsigned i = 0; good && i < in->mNumMeshes; i++)
        good = mesh_file_send_part(to, in->mMeshes[i], z_up);
    for (unsigned i = 0; good && i < in->mNumMeshes; i++) {
        good = mesh_file_send_faces(to, in->mMeshes[i], first);
        first += in->mMeshes[i]->mNumVertices;
    }
    return good;
}

static inline void mesh_file_limit(int what, uint64_t amount) {
    struct rlimit limit;
    if (getrlimit(what, &limit) != 0) return;
    if (limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur > (rlim_t)amount)
        limit.rlim_cur = (rlim_t)amount;
    setrlimit(what, &limit);
}

// Does not return. It may have a gigabyte and 400 bytes for each of the file's, and 5 seconds and
// one for each megabyte: fifty times the time that a PLY file of a million triangles takes.
static inline void mesh_file_child(int to, const char *path, int z_up, uint64_t size) {
    FILE *pipe = fdopen(to, "wb"),
         *quiet = freopen("/dev/null", "w", stderr); // what assimp says when it dies
    mesh_file_limit(RLIMIT_CORE, 0);
    mesh_file_limit(RLIMIT_CPU, 5 + size / 1000000);
#ifndef __SANITIZE_ADDRESS__ // which maps terabytes
    mesh_file_limit(RLIMIT_AS, ((uint64_t)1 << 30) + 400 * size);
#endif
    int good = pipe && quiet && mesh_file_send_all(pipe, path, z_up);
    _exit(good && fclose(pipe) == 0 ? 0 : 1);
}

// ---- The parent

static inline int mesh_file_receive(FILE *from, mesh_file *f) {
    if (fread(f->reason, 1, sizeof f->reason, from) != sizeof f->reason) return 0;
    if (fread(&f->vertices, sizeof f->vertices, 1, from) != 1) return 0;
    if (fread(&f->triangles, sizeof f->triangles, 1, from) != 1) return 0;
    if (f->reason[0]) return 1;
    f->xyz = (float *)malloc((size_t)(3 * f->vertices + 1) * sizeof *f->xyz);
    f->corner = (uint32_t *)malloc((size_t)(3 * f->triangles + 1) * sizeof *f->corner);
    if (!f->xyz || !f->corner) {
        snprintf(f->reason, sizeof f->reason, "it does not fit into memory");
        return 1;
    }
    return fread(f->xyz, 3 * sizeof *f->xyz, (size_t)f->vertices, from) == f->vertices &&
           fread(f->corner, 3 * sizeof *f->corner, (size_t)f->triangles, from) == f->triangles;
}

// How large a file is that can be read; 0 with the reason. A pipe would wait for who writes into
// it, and assimp wants to go back and forth.
static inline uint64_t mesh_file_size(mesh_file *f, const char *path) {
    struct stat there;
    errno = 0;
    if (stat(path, &there) == 0 && !S_ISREG(there.st_mode) && !S_ISDIR(there.st_mode)) {
        snprintf(f->reason, sizeof f->reason, "it is a pipe or a device, not a file");
        return 0;
    }
    FILE *file = fopen(path, "rb");
    long size = -1;
    if (file && fgetc(file) != EOF && fseek(file, 0, SEEK_END) == 0) size = ftell(file);
    if (size <= 0)
        snprintf(f->reason, sizeof f->reason, "%s", errno ? strerror(errno) : "it is empty");
    if (file) fclose(file);
    return size > 0 ? (uint64_t)size : 0;
}

// Call before any thread is started; mesh_file_free() in every case.
static inline void mesh_file_read(mesh_file *f, const char *path, int z_up) {
    int ends[2], status = 0;
    memset(f, 0, sizeof *f);
    uint64_t size = mesh_file_size(f, path);
    if (!size) return;
    fflush(NULL); // or the child has a copy of what waits to be written
    pid_t child = pipe(ends) == 0 ? fork() : -1;
    if (child < 0) {
        snprintf(f->reason, sizeof f->reason, "%s", strerror(errno));
        return;
    }
    if (child == 0) {
        close(ends[0]);
        mesh_file_child(ends[1], path, z_up, size);
    }
    close(ends[1]);
    FILE *from = fdopen(ends[0], "rb");
    int good = from && mesh_file_receive(from, f);
    if (from) fclose(from);
    waitpid(child, &status, 0);
    int endless = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
    if (!good)
        snprintf(f->reason, sizeof f->reason, "it is damaged: assimp %s",
                 endless ? "comes to no end" : "breaks down");
}

#endif
