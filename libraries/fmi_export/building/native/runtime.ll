; What numba's own runtime does for Python, as far as an FMU needs it. It stands here in the open, to be optimised away.

; Every exception is the same one, which says nothing: the pickled ones hold paths of this machine.
@no_exception = internal constant { ptr, i32, ptr, ptr, i32 } zeroinitializer

; The entries count references to the arrays that they make of addresses; these arrays have no owner.
define internal void @NRT_incref(ptr %p) { ret void }
define internal void @NRT_decref(ptr %p) { ret void }

; Strides of a view of an array in another shape, for elements that stand one after another, last index fastest; else 0.
define internal i32 @numba_attempt_nocopy_reshape(i64 %count, ptr %sizes, ptr %strides, i64 %new_count, ptr %new_sizes, ptr %new_strides, i64 %item, i32 %fortran) alwaysinline {
begin:
  %other_order = icmp ne i32 %fortran, 0
  br i1 %other_order, label %no, label %check
check:
  %i = phi i64 [ %count, %begin ], [ %i_next, %compare ]
  %expected = phi i64 [ %item, %begin ], [ %expected_next, %compare ]
  %all = icmp eq i64 %i, 0
  br i1 %all, label %write, label %compare
compare:
  %i_next = sub i64 %i, 1
  %size_at = getelementptr i64, ptr %sizes, i64 %i_next
  %size = load i64, ptr %size_at
  %stride_at = getelementptr i64, ptr %strides, i64 %i_next
  %stride = load i64, ptr %stride_at
  %single = icmp eq i64 %size, 1
  %close = icmp eq i64 %stride, %expected
  %good = or i1 %single, %close
  %expected_next = mul i64 %expected, %size
  br i1 %good, label %check, label %no
write:
  %k = phi i64 [ %new_count, %check ], [ %k_next, %put ]
  %step = phi i64 [ %item, %check ], [ %step_next, %put ]
  %written = icmp eq i64 %k, 0
  br i1 %written, label %yes, label %put
put:
  %k_next = sub i64 %k, 1
  %new_stride_at = getelementptr i64, ptr %new_strides, i64 %k_next
  store i64 %step, ptr %new_stride_at
  %new_size_at = getelementptr i64, ptr %new_sizes, i64 %k_next
  %new_size = load i64, ptr %new_size_at
  %step_next = mul i64 %step, %new_size
  br label %write
yes:
  ret i32 1
no:
  ret i32 0
}
