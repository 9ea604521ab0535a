/* Codels as genom3's skeletons have them: plain C, nothing of bipc. */
#include "actrack.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "track_c_types.h"

struct track_tally_s {
  unsigned long long codels;
};

static genom_event far_from(double distance, const char *what, const genom_context self)
{
  track_e_far_detail d;
  d.distance = distance;
  strncpy(d.what, what, sizeof(d.what) - 1);
  d.what[sizeof(d.what) - 1] = '\0';
  return track_e_far(&d, self);
}

/* --- Task motion ------------------------------------------------------- */

/** Codel trackStart of task motion.
 *
 * Triggered by track_start.
 * Yields to track_main.
 */
genom_event
trackStart(track_ids *ids, const track_place *place,
           const genom_context self)
{
  ids->drive.speed = 1.;
  ids->drive.limit.high = 2.;
  ids->tally = calloc(1, sizeof(*ids->tally));
  if (!ids->tally) return far_from(0., "no memory", self);
  *place->data(self) = ids->position;
  place->write(self);
  return track_main;
}

genom_event
trackMain(const geometry_point *position, track_tally_s **tally,
          const track_place *place, const genom_context self)
{
  geometry_point *p = place->data(self);
  p->x = position->x;
  p->y = position->y;
  (*tally)->codels++;
  if (place->write(self) != genom_ok) return track_ether;
  return track_pause_main;
}

genom_event
trackStop(track_tally_s **tally, const genom_context self)
{
  (void)self;
  fputs("track: stopped\n", stderr);
  free(*tally);
  return track_ether;
}

/* --- Attributes and functions ------------------------------------------ */

genom_event
trackCheckSpeed(double speed, const track_ids_drive_s *drive, const genom_context self)
{
  if (speed < drive->limit.low || speed > drive->limit.high) return far_from(speed, "speed", self);
  return genom_ok;
}

genom_event
trackWeigh(const geometry_marks *marks, const optional_double *scale, const track_shape *outline,
           track_gait pace, double *sum, char verdict[16], const genom_context self)
{
  uint32_t i;
  (void)self;
  *sum = outline->_d == track_CREEP ? outline->_u.width : outline->_u.corner.x * outline->_u.corner.y;
  for (i = 0; i < marks->_length; i++)
    *sum += marks->_buffer[i] * (scale->_present ? scale->_value : 1.);
  snprintf(verdict, 16, "%s of %d", pace == track_RUN ? "fast" : "slow", (int)marks->_length);
  return genom_ok;
}

/* A bounded sequence has room for its bound, also one of a union. */
genom_event
trackReserve(uint32_t length, geometry_marks *marks, track_load *packed, const genom_context self)
{
  packed->_d = track_WALK;
  if (genom_sequence_reserve(marks, length) || genom_sequence_reserve(&packed->_u.marks, length))
    return far_from(length, "marks", self);
  marks->_length = packed->_u.marks._length = length;
  while (length--) marks->_buffer[length] = packed->_u.marks._buffer[length] = length;
  return genom_ok;
}

genom_event
trackRemember(const char *text, uint8_t times, bool loud, char **note, const genom_context self)
{
  (void)self;
  (void)loud;
  free(*note);
  *note = malloc(strlen(text) * times + 1);
  **note = '\0';
  while (times--) strcat(*note, text);
  return genom_ok;
}

genom_event
trackLoud(bool loud, char **note, const genom_context self)
{
  char *c;
  (void)self;
  for (c = *note; loud && *c; c++)
    if (*c >= 'a' && *c <= 'z') *c += 'A' - 'a';
  return genom_ok;
}

genom_event
trackGauge(const char name[8], double value, const track_gauge *gauge, const genom_context self)
{
  if (!*name) return track_e_empty(self);
  if (gauge->data(name, self) == NULL) {
    genom_event e = gauge->write(name, self);
    genom_event r;
    self->raised(&r, self);
    if (e != genom_no_such_outport_id || r != e) return far_from(1., "a port that is not open", self);
    if (gauge->open(name, self) != genom_ok) return far_from(2., name, self);
  }
  *gauge->data(name, self) = value;
  return gauge->write(name, self);
}

genom_event
trackCount(const track_tally_s *tally, uint64_t *codels, const genom_context self)
{
  (void)self;
  *codels = tally->codels;
  return genom_ok;
}

/* --- Activity follow --------------------------------------------------- */

genom_event
followCheck(const geometry_path *path, double tolerance, const genom_context self)
{
  uint32_t i;
  if (!path->_length) return track_e_empty(self);
  if (tolerance <= 0.) return far_from(tolerance, "tolerance", self);
  for (i = 0; i < path->_length; i++)
    if (hypot(path->_buffer[i].x, path->_buffer[i].y) > track_far_away)
      return far_from(hypot(path->_buffer[i].x, path->_buffer[i].y), "point", self);
  return genom_ok;
}

genom_event
followStart(const geometry_path *path, uint32_t *at, double *length, sequence_geometry_point *visited,
            const genom_context self)
{
  (void)self;
  if (genom_sequence_reserve(visited, path->_length)) return track_ether;
  visited->_length = 0;
  *at = 0;
  *length = 0.;
  return track_step;
}

genom_event
followStep(const geometry_path *path, double tolerance, uint32_t *at, double *length, int32_t *laps, double speed,
           geometry_point *position, sequence_geometry_point *visited, double left[2], const genom_context self)
{
  const double reach = speed * 0.01;
  double distance;
  (void)self;
  left[0] = path->_buffer[*at].x - position->x;
  left[1] = path->_buffer[*at].y - position->y;
  distance = hypot(left[0], left[1]);
  if (distance > fmax(reach, tolerance)) {
    position->x += left[0] / distance * reach;
    position->y += left[1] / distance * reach;
    *length += reach;
    return track_pause_step;
  }
  *length += distance;
  *position = path->_buffer[*at];
  if (genom_sequence_reserve(visited, visited->_length + 1)) return track_ether;
  visited->_buffer[visited->_length++] = *position;
  if (++*at < path->_length) return track_step;
  *at = 0;
  return --*laps > 0 ? track_step : track_ether;
}

genom_event
followStop(char **note, const genom_context self)
{
  (void)self;
  free(*note);
  *note = strdup("stopped");
  return track_ether;
}
