/* The data of an FMU: variable table, constants and sentences, in the format that data.py writes.

       header | constants | start values | minima | maxima | faults | warnings | variables | pieces | types | text |
       checksum

   The constants of an assembly are its wiring, its parts, tables and the data of each part; see `Wiring`. Numbers
   are little-endian, as on all supported processors. The engine, which is this library, reads the bytes in place; they
   must begin at a multiple of 16, so that the header and the constants do. */

#ifndef AMB_DATA_H
#define AMB_DATA_H

#include <stddef.h>
#include <stdint.h>

enum { KEY_SIZE = 32, GUID_SIZE = 48 };

enum { TEXT_SIZE = 4096 }; /* of every sentence; data.py refuses those that leave no room for additions */

typedef enum { TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_STRING } Type;

typedef struct {
    char magic[8];
    uint64_t version;
    char key[KEY_SIZE]; /* of the engine that the data are for, without a final zero */
    char guid[GUID_SIZE];
    uint64_t n_parameters, n_inputs, n_outputs, n_state, n_work, n_constants, n_faults, n_warnings, n_pieces, n_text;
    uint64_t kernels; /* number of the model among those of the engine */
    uint64_t n_parts; /* 0 for a model that has kernels */
} Header;

/* Texts are identified by their position in `text`. */
typedef struct {
    uint32_t name;
    uint32_t kind;    /* "fixed parameter" */
    uint32_t allowed; /* what follows name and value in the sentence for a value outside the range */
    uint32_t tunable;
    uint32_t length; /* in FMI 3.0: 1, or of the array that begins here, or 0 within an array */
    float nominal;
} Variable;

/* Text, followed by the value of a variable, or of one of these. */
enum { NO_VALUE = -1, STEP_SIZE = -2 };

typedef struct {
    uint32_t text;
    int32_t variable;
} Piece;

typedef struct {
    int64_t of; /* a fault's code, or the variable that is a warning */
    uint32_t first_piece, n_pieces;
} Sentence;

/* The beginning of the constants of an assembly. A `Part` for each part follows, and these tables of int64_t:

       sources:  position of the source of each input of each part: first the inputs of the assembly, then its outputs,
                 which are the outputs of the parts in turn without their fault codes
       ramps:    position of an input of the assembly, and of the input that is its slope over a step
       gathered: an output that covers a whole step, and whether it is the largest value (0), the sum (1) or the mean
                 over time (2) */
typedef struct {
    int64_t n_sources, n_ramps, n_gathered;
    int64_t jacobi;      /* whether all parts read the outputs of the others at the beginning of a step */
    int64_t sample_time; /* parameter with the time between two instants at which steps are divided, or -1 */
    double step_size;    /* that time (s) if there is no such parameter */
} Wiring;

typedef struct {
    uint64_t name;     /* of the component, its place in `text` */
    uint64_t data;     /* first byte of its data, counted from the constants; a multiple of 16 */
    uint64_t size;     /* of its data in bytes */
    int64_t n_samples; /* instants that a step of it spans */
} Part;

enum { MOST_PARTS = 8 }; /* so that fault codes can identify the part; as in `fmi_export/model.py` */

/* Views of the data. Variables are ordered parameters, inputs, outputs; the last output is the fault code. */
typedef struct {
    const char *guid;
    int64_t n_parameters, n_inputs, n_outputs, n_values, n_state, n_work, n_constants, n_faults, n_warnings;
    uint64_t n_text, kernels, n_parts;
    const double *constants, *start_values, *minima, *maxima;
    const Sentence *faults, *warnings;
    const Variable *variables;
    const Piece *pieces;
    const unsigned char *types; /* of the variables, close together */
    const char *text;
} Data;

#pragma GCC visibility push(hidden)

/* Whether the bytes are complete data for this engine; if not, `reason` (TEXT_SIZE) says why. */
int data_is_valid(const unsigned char *bytes, size_t size, char *reason);

/* Views of the data in valid bytes, which must not be freed before. */
Data data_in(const unsigned char *bytes);

/* CRC-32 as zlib has it. */
uint32_t checksum(const void *bytes, size_t size);

#pragma GCC visibility pop

static inline const char *name_of(const Data *data, int64_t variable)
{
    return data->text + data->variables[variable].name;
}

#endif
