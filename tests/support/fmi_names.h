/* Names of functions in both versions of FMI: those of FMI 3.0 stand for those of FMI 2.0 too. */
#if FMI_VERSION == 3
#define FMI(name) fmi3##name
#define N_VALUES , size_t n_values
#else
#define FMI(name) fmi2##name
#define N_VALUES
#define fmi2SetFloat64 fmi2SetReal
#define fmi2GetFloat64 fmi2GetReal
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#endif
