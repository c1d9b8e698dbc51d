/* Functions of FMI that an FMU of the tests must have, and that do nothing but what CALL(name) defines. */
#define CALL3(a, b, c) CALL(a) CALL(b) CALL(c)
CALL(Terminate)
CALL(Reset) CALL(SetDebugLogging) CALL3(GetString, SetString,
                                        GetBoolean) CALL(SetBoolean) CALL(GetDirectionalDerivative)
#if FMI_VERSION == 3
    CALL3(InstantiateModelExchange, InstantiateScheduledExecution,
          SerializedFMUStateSize) CALL(SerializeFMUState) CALL(DeserializeFMUState) CALL3(GetFloat32, GetInt8, GetUInt8)
        CALL3(GetInt16, GetUInt16, GetInt32) CALL3(GetUInt32, GetInt64, GetUInt64) CALL3(SetFloat32, SetInt8, SetUInt8)
            CALL3(SetInt16, SetUInt16, SetInt32) CALL3(SetUInt32, SetInt64, SetUInt64)
                CALL3(GetBinary, SetBinary, GetClock) CALL3(SetClock, GetIntervalDecimal, GetIntervalFraction)
                    CALL3(GetShiftDecimal, GetShiftFraction,
                          SetIntervalDecimal) CALL3(SetIntervalFraction, SetShiftDecimal, SetShiftFraction)
                        CALL3(EnterEventMode, EnterStepMode, EvaluateDiscreteStates)
                            CALL3(UpdateDiscreteStates, SetTime, SetContinuousStates)
                                CALL3(EnterConfigurationMode, ExitConfigurationMode, GetNumberOfVariableDependencies)
                                    CALL3(GetVariableDependencies, GetAdjointDerivative, GetOutputDerivatives)
                                        CALL3(EnterContinuousTimeMode, CompletedIntegratorStep,
                                              GetContinuousStateDerivatives)
                                            CALL3(GetEventIndicators, GetContinuousStates, ActivateModelPartition)
                                                CALL3(GetNominalsOfContinuousStates, GetNumberOfEventIndicators,
                                                      GetNumberOfContinuousStates)
#else
    CALL(GetInteger) CALL(SetInteger) CALL3(SerializedFMUstateSize, SerializeFMUstate, DeSerializeFMUstate)
        CALL3(SetRealInputDerivatives, GetRealOutputDerivatives, CancelStep)
            CALL3(GetStatus, GetIntegerStatus, GetBooleanStatus) CALL(GetStringStatus)
#endif
