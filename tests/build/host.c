/* Follows a motion with the kernel library alone: host IMAGE, an image of a system and a run (images.py), which it replaces. */
#include "gearplay.h"

#include <stdio.h>
#include <stdlib.h>

enum { PAUSED = 1, LOGGED = 7 };

int main(int count, char **words) {
    int64_t head[4]; /* bytes of the image, relocations, places of the system and the run */
    FILE *file = count == 2 ? fopen(words[1], "rb") : NULL;
    if (!file || fread(head, 8, 4, file) != 4) return 2;
    int64_t *places = malloc(8 * head[1] + 8);
    char *image = malloc(head[0]);
    if (fread(places, 8, head[1], file) != (size_t)head[1] || fread(image, 1, head[0], file) != (size_t)head[0]) return 3;
    fclose(file);
    for (int64_t n = 0; n < head[1]; n++) *(int64_t *)(image + places[n]) += (int64_t)(intptr_t)image;
    const gearplay_System *system = (const gearplay_System *)(image + head[2]);
    const gearplay_Run *run = (const gearplay_Run *)(image + head[3]);
    int64_t status = PAUSED;
    while (status == PAUSED) {
        void *fault = NULL;
        run->counts[LOGGED] = 0;
        if (gearplay_integrate_stepper_advance(&status, &fault, system, run, 1000) != 0) return 4;
    }
    for (int64_t n = 0; n < head[1]; n++) *(int64_t *)(image + places[n]) -= (int64_t)(intptr_t)image;
    file = fopen(words[1], "wb");
    if (!file || fwrite(image, 1, head[0], file) != (size_t)head[0]) return 5;
    return fclose(file) || status != 0;
}
