/* A co-simulation without Python: Gauss-Seidel over FMUs, as the text on its standard input says.

       components COUNT    first N    last N    step H    values COUNT    exogenous COUNT
       then for each component, in the order of visits:
       LIBRARY GUID RESOURCES NAME every M parameters P inputs I outputs O
           P lines: type reference value      I lines: type reference position      O lines: type reference position
       events COUNT, then COUNT lines: point position value
       initial: the exogenous values

   Positions are those in one array of values: the exogenous inputs, then the outputs of each component. At every point
   from 0 on it prints all values as hexadecimal numbers. Types are r, i and b. */

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "logger.h"

#define FUNCTIONS(X)                                                                                                   \
    X(Instantiate)                                                                                                     \
    X(SetupExperiment)                                                                                                 \
    X(EnterInitializationMode)                                                                                         \
    X(ExitInitializationMode)                                                                                          \
    X(SetReal) X(SetInteger) X(SetBoolean) X(GetReal) X(GetInteger) X(GetBoolean) X(DoStep) X(Terminate) X(FreeInstance)

typedef struct {
    char type;
    unsigned reference;
    int position;
    double value;
} Port;

typedef struct {
#define MEMBER(name) __typeof__(&fmi2##name) name;
    FUNCTIONS(MEMBER)
    fmi2Component instance;
    int every, inputs, outputs;
    Port *input, *output;
} Component;

static void require(int condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "failed: %s\n", what);
        exit(1);
    }
}

static void set(Component *c, Port p, double value)
{
    fmi2Integer number = (fmi2Integer)value;
    fmi2Boolean flag = value != 0.0;
    fmi2Status status = p.type == 'r'   ? c->SetReal(c->instance, &p.reference, 1, &value)
                        : p.type == 'i' ? c->SetInteger(c->instance, &p.reference, 1, &number)
                                        : c->SetBoolean(c->instance, &p.reference, 1, &flag);
    require(status == fmi2OK, "set");
}

static double get(Component *c, Port p)
{
    double value;
    fmi2Integer number;
    fmi2Boolean flag;
    if (p.type == 'r') {
        require(c->GetReal(c->instance, &p.reference, 1, &value) == fmi2OK, "get");
        return value;
    }
    if (p.type == 'i') {
        require(c->GetInteger(c->instance, &p.reference, 1, &number) == fmi2OK, "get");
        return number;
    }
    require(c->GetBoolean(c->instance, &p.reference, 1, &flag) == fmi2OK, "get");
    return flag;
}

static void give(Component *c, const double *values)
{
    for (int i = 0; i < c->inputs; i++)
        set(c, c->input[i], values[c->input[i].position]);
}

static void take(Component *c, double *values)
{
    for (int i = 0; i < c->outputs; i++)
        values[c->output[i].position] = get(c, c->output[i]);
}

static Port read_port(int with_value)
{
    Port p = {0};
    if (with_value)
        require(scanf(" %c %u %lf", &p.type, &p.reference, &p.value) == 3, "reading a parameter");
    else
        require(scanf(" %c %u %d", &p.type, &p.reference, &p.position) == 3, "reading a connection");
    return p;
}

static void load(Component *c)
{
    char path[4096], guid[128], resources[4096], name[128];
    int parameters;
    static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    require(scanf(" %4095s %127s %4095s %127s every %d parameters %d inputs %d outputs %d", path, guid, resources, name,
                  &c->every, &parameters, &c->inputs, &c->outputs) == 8,
            "reading a component");
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    require(library != NULL, path);
#define FIND(function)                                                                                                 \
    *(void **)&c->function = dlsym(library, "fmi2" #function);                                                         \
    require(c->function != NULL, #function);
    FUNCTIONS(FIND)
    c->instance = c->Instantiate(name, fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2False);
    require(c->instance != NULL, name);
    for (int i = 0; i < parameters; i++) {
        Port p = read_port(1);
        set(c, p, p.value);
    }
    c->input = calloc(c->inputs + 1, sizeof(Port));
    c->output = calloc(c->outputs + 1, sizeof(Port));
    for (int i = 0; i < c->inputs; i++)
        c->input[i] = read_port(0);
    for (int i = 0; i < c->outputs; i++)
        c->output[i] = read_port(0);
}

int main(void)
{
    int components, first, last, count, exogenous, events;
    double h;
    require(scanf("components %d first %d last %d step %lf values %d exogenous %d", &components, &first, &last, &h,
                  &count, &exogenous) == 6,
            "reading the head");
    Component *c = calloc(components, sizeof(Component));
    for (int k = 0; k < components; k++)
        load(&c[k]);
    require(scanf(" events %d", &events) == 1, "reading the events");
    int *point = calloc(events + 1, sizeof(int)), *position = calloc(events + 1, sizeof(int));
    double *becomes = calloc(events + 1, sizeof(double)), *values = calloc(count, sizeof(double));
    double *before = calloc(count, sizeof(double));
    for (int i = 0; i < events; i++)
        require(scanf("%d %d %lf", &point[i], &position[i], &becomes[i]) == 3, "reading an event");
    require(scanf(" initial:") == 0, "reading the first values");
    for (int i = 0; i < exogenous; i++)
        require(scanf("%lf", &values[i]) == 1, "reading the first values");

    for (int k = 0; k < components; k++) {
        require(c[k].SetupExperiment(c[k].instance, fmi2False, 0.0, first * h, fmi2False, 0.0) == fmi2OK, "setup");
        require(c[k].EnterInitializationMode(c[k].instance) == fmi2OK, "enter");
    }
    do {
        memcpy(before, values, count * sizeof(double));
        for (int k = 0; k < components; k++) {
            give(&c[k], values);
            take(&c[k], values);
        }
    } while (memcmp(before, values, count * sizeof(double)) != 0);
    for (int k = 0; k < components; k++)
        require(c[k].ExitInitializationMode(c[k].instance) == fmi2OK, "exit");

    for (int n = first; n <= last; n++) {
        for (int i = 0; i < events; i++)
            if (point[i] == n)
                values[position[i]] = becomes[i];
        if (n >= 0) {
            for (int i = 0; i < count; i++)
                printf("%a ", values[i]);
            printf("\n");
        }
        for (int k = 0; k < components && n < last; k++)
            if (n % c[k].every == 0) {
                give(&c[k], values);
                require(c[k].DoStep(c[k].instance, n * h, c[k].every * h, fmi2True) == fmi2OK, "step");
                take(&c[k], values);
            }
    }
    for (int k = 0; k < components; k++) {
        require(c[k].Terminate(c[k].instance) == fmi2OK, "terminate");
        c[k].FreeInstance(c[k].instance);
    }
    return 0;
}
