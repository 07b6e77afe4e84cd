/* What elastic.c dispatches to: one file a kind of body. A part is called with a checked body:
 * indices in range, every vertex used, material in range.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_ELASTIC_PARTS_H
#define BAKE_ELASTIC_PARTS_H

#include "body.h"

/* Sets b->elements, one block from bake_alloc (a struct of the part's own, with what follows it, if
 * need be): body_free releases it by free(). Adds each element's share to b->mass, which is zeroed
 * before. After a failure nothing need be undone. */
int solid_prepare(body *b, bake_error *error);
double solid_energy(const body *b, const double *x);
/* Added to `gradient`, which is zeroed before. */
void solid_gradient(const body *b, const double *x, double *gradient);
void solid_hessian(const body *b, const double *x, body_blocks *out);

int shell_prepare(body *b, bake_error *error);
double shell_energy(const body *b, const double *x);
void shell_gradient(const body *b, const double *x, double *gradient);
void shell_hessian(const body *b, const double *x, body_blocks *out);

/* Room for `count` more blocks at once, all zero; their first. */
body_block *body_blocks_room(body_blocks *list, size_t count);

#endif
