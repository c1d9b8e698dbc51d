#include "data.h"

#include <stdio.h>
#include <string.h>

#include "engine_key.h" /* ENGINE_KEY */

enum { VERSION = 5 };
static const char MAGIC[8] = "ambdata"; /* and a zero */
static const uint64_t MOST = 1u << 28;  /* of anything, so that no size overflows */

/* Arrays that compile if the constants, which follow the header, are in place, and if a key fills its own. */
typedef char header_ends_at_a_multiple[sizeof(Header) % 16 == 0 ? 1 : -1];
typedef char key_fills_its_place[sizeof ENGINE_KEY == KEY_SIZE + 1 ? 1 : -1];

uint32_t checksum(const void *bytes, size_t size)
{
    static const uint32_t table[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c,
    };
    const unsigned char *at = bytes;
    uint32_t sum = ~0u;
    for (size_t i = 0; i < size; i++) {
        sum ^= at[i];
        sum = sum >> 4 ^ table[sum & 15];
        sum = sum >> 4 ^ table[sum & 15];
    }
    return ~sum;
}

static uint64_t n_values(const Header *header) { return header->n_parameters + header->n_inputs + header->n_outputs; }

/* Size of valid data without their checksum. */
static uint64_t size_of(const Header *header)
{
    return sizeof *header + 8 * header->n_constants + sizeof(Sentence) * header->n_faults +
           sizeof(Sentence) * header->n_warnings + (3 * 8 + sizeof(Variable) + 1) * n_values(header) +
           sizeof(Piece) * header->n_pieces + header->n_text;
}

static int sizes_are_possible(const Header *header)
{
    const uint64_t counts[] = {header->n_parameters, header->n_inputs,    header->n_outputs, header->n_state,
                               header->n_work,       header->n_constants, header->n_faults,  header->n_warnings,
                               header->n_pieces,     header->n_text};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        if (counts[i] > MOST)
            return 0;
    return header->n_outputs > 0 && header->n_text > 0 && header->n_parts <= MOST_PARTS &&
           memchr(header->guid, '\0', GUID_SIZE);
}

/* Whether all texts, pieces and variables that are referred to exist. */
static int references_are_possible(const Data *data, const Header *header)
{
    const uint64_t n_text = header->n_text;
    if (data->text[n_text - 1] != '\0')
        return 0;
    for (int64_t i = 0; i < data->n_values; i++) {
        const Variable *v = &data->variables[i];
        if (v->name >= n_text || v->kind >= n_text || v->allowed >= n_text || data->types[i] >= TYPE_STRING)
            return 0;
        if (v->length > (uint64_t)(data->n_values - i))
            return 0;
    }
    for (uint64_t i = 0; i < header->n_pieces; i++)
        if (data->pieces[i].text >= n_text || data->pieces[i].variable < STEP_SIZE ||
            data->pieces[i].variable >= data->n_values)
            return 0;
    for (int64_t i = 0; i < data->n_faults + data->n_warnings; i++)
        if ((uint64_t)data->faults[i].first_piece + data->faults[i].n_pieces > header->n_pieces)
            return 0;
    for (int64_t i = 0; i < data->n_warnings; i++)
        if (data->warnings[i].of < 0 || data->warnings[i].of >= data->n_values)
            return 0;
    return 1;
}

int data_is_valid(const unsigned char *bytes, size_t size, char *reason)
{
    const Header *header = (const Header *)bytes;
    uint32_t sum;
    *reason = '\0';
    if (size < sizeof *header || memcmp(header->magic, MAGIC, sizeof MAGIC) != 0)
        snprintf(reason, TEXT_SIZE, "it contains no data of an FMU");
    else if (header->version != VERSION)
        snprintf(reason, TEXT_SIZE, "its format has number %llu, but the library reads number %d",
                 (unsigned long long)header->version, VERSION);
    else if (!sizes_are_possible(header))
        snprintf(reason, TEXT_SIZE, "it is damaged: its sizes are impossible");
    else if (size != size_of(header) + sizeof sum)
        snprintf(reason, TEXT_SIZE, "it has the wrong size, %llu bytes instead of %llu", (unsigned long long)size,
                 (unsigned long long)(size_of(header) + sizeof sum));
    if (*reason)
        return 0;
    memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
    Data data = data_in(bytes);
    if (sum != checksum(bytes, size - sizeof sum))
        snprintf(reason, TEXT_SIZE, "it is damaged: its checksum is wrong");
    else if (memcmp(header->key, ENGINE_KEY, KEY_SIZE) != 0)
        snprintf(reason, TEXT_SIZE, "it is for engine %.*s, but the library is engine %s", KEY_SIZE, header->key,
                 ENGINE_KEY);
    else if (!references_are_possible(&data, header))
        snprintf(reason, TEXT_SIZE, "it is damaged: its references are impossible");
    return !*reason;
}

Data data_in(const unsigned char *bytes)
{
    const Header *header = (const Header *)bytes;
    uint64_t n = n_values(header);
    Data data = {
        .guid = header->guid,
        .n_parameters = (int64_t)header->n_parameters,
        .n_inputs = (int64_t)header->n_inputs,
        .n_outputs = (int64_t)header->n_outputs,
        .n_values = (int64_t)n,
        .n_state = (int64_t)header->n_state,
        .n_work = (int64_t)header->n_work,
        .n_constants = (int64_t)header->n_constants,
        .n_faults = (int64_t)header->n_faults,
        .n_warnings = (int64_t)header->n_warnings,
        .n_text = header->n_text,
        .kernels = header->kernels,
        .n_parts = header->n_parts,
    };
    data.constants = (const double *)(header + 1);
    data.start_values = data.constants + header->n_constants;
    data.minima = data.start_values + n;
    data.maxima = data.minima + n;
    data.faults = (const Sentence *)(data.maxima + n);
    data.warnings = data.faults + header->n_faults;
    data.variables = (const Variable *)(data.warnings + header->n_warnings);
    data.pieces = (const Piece *)(data.variables + n);
    data.types = (const unsigned char *)(data.pieces + header->n_pieces);
    data.text = (const char *)(data.types + n);
    return data;
}
