-- DMC: marker, id, type, length, data and a checksum over all of it. Serial lines, as DLT_USER0, or TCP by "Decode As".

each_rows(RIGS)

local HEADER = rows({
  { "marker", "bytes", size = 2 }, { "id", "u32" }, { "type", "u16", hex = true }, { "length", "u16" },
})
local CHECKSUM = rows({ { "checksum", "bytes", size = 2 } })[1]
-- No receiver accepts a longer frame.
local LONGEST = 2048

-- Whether the Fletcher-16 sum over a whole frame is zero.
local function is_sound(frame)
  local first, second = 0, 0
  for index = 1, #frame do
    first = (first + frame:byte(index)) % 255
    second = (second + first) % 255
  end
  return first == 0 and second == 0
end

-- What begins at an offset: "sound", "damaged" or "short", and the size of the frame; nil if no frame begins there.
local function look(bytes, at)
  local header = bytes:sub(at + 1, at + 10)
  if header:sub(1, 2) ~= MARKER:sub(1, #header) then return nil end
  if #header < 10 then return "short" end
  local size = 12 + header:byte(9) + 256 * header:byte(10)
  if #bytes - at < size then return "short", size end
  return is_sound(bytes:sub(at + 1, at + size)) and "sound" or "damaged", size
end

-- Offset of the next sound frame before `stop`.
local function next_sound(bytes, at, stop)
  repeat
    at = bytes:find(MARKER, at + 2, true)
    if not at or at > stop then return nil end
    at = at - 1
    local what, size = look(bytes, at)
  until what == "sound" and size <= LONGEST
  return at
end

function next_frame(tvb, at)
  local bytes = tvb:raw()
  local what, size = look(bytes, at)
  if what == "sound" then return "frame", size end
  if not what then
    local marker = bytes:find(MARKER, at + 1, true)
    local last = bytes:sub(-1) == "D" and #bytes
    return "noise", (marker or last or #bytes + 1) - 1 - at
  end
  -- A marker in noise, or a damaged length: a sound frame inside tells.
  local sound = next_sound(bytes, at, what == "damaged" and at + size or #bytes)
  if sound then return "noise", sound - at end
  if what == "damaged" and size <= LONGEST then return "frame", size end
  if size and size > LONGEST then return "noise", 2 end
  return "more", size
end

function read_frame(tvb, at, size, sender, pinfo)
  local id, kind = tvb(at + 2, 4):le_uint(), tvb(at + 6, 2):le_uint()
  local frame = { header = HEADER, body = at + 10, stop = at + size - 2, tag = id }
  local request = waiting[line_of(pinfo) .. " " .. id]
  if not sender then
    local host, device = messages_of("host", kind)[1], messages_of("device", kind)[1]
    local answers = request and request.number < pinfo.number and request.frame.kind == kind
    local guess = (kind >= 0x8000 or id == 0 or answers or not host) and device and "device" or "host"
    local first = seen[id_of(pinfo, tvb, at, size)]
    sender = first and first.frame.sender or guess
  end
  frame.sender, frame.kind = sender, kind
  frame.message = messages_of(sender, kind)[1]
  frame.asks = sender == "host"
  frame.answers = sender == "device"
  frame.unasked = id == 0
  frame.finish = function(tree)
    local item = add_value(tree, CHECKSUM, tvb(at + size - 2, 2))
    if not is_sound(tvb:raw(at, size)) then item:add_proto_expert_info(E.checksum) end
    if sender == "device" and kind >= 0x8000 and size >= 14 then
      local code = tvb(at + 10, 2):le_uint()
      if code ~= 0x10 then
        tree:add_proto_expert_info(E.refused, "The device refuses: " .. (N.response_code[code] or code))
      end
    end
  end
  return frame
end

-- The first byte of a configuration says which rig the rest describes.
local KIND = rows({ { "type", "u8", names = N.rig } })[1]
local OPAQUE = rows({ { "opaque", "bytes" } })[1]
local BOOM_TABLE = rows({ { "boom_table", "i32", times = 121 } })[1]
local DISTANCE = rows({ { "safe_distance_x1000", "u32", decimals = 3, needs = 4 } })
function BY_HAND.VirtConfig(tree, tvb, at, stop)
  if at == stop then return nil, "type", at end
  local kind = tvb(at, 1):uint()
  add_value(tree, KIND, tvb(at, 1))
  at = at + 1
  if kind > 2 then
    if at < stop then add_value(tree, OPAQUE, tvb(at, stop - at)) end
    return stop
  end
  local after, name, from = add_rows(tree, tvb, at, stop, RIGS[kind] or {})
  if not after or kind ~= 1 then return after, name, from end
  if stop - after >= 484 then after = add_row(tree, tvb, after, stop, BOOM_TABLE) end
  return add_rows(tree, tvb, after, stop, DISTANCE)
end

proto.dissector = dissect
proto.fields, proto.experts = all_fields, E
DissectorTable.get("wtap_encap"):add(wtap_encaps.USER0, proto)
DissectorTable.get("tcp.port"):add_for_decode_as(proto)
-- A serial adapter: the checksum makes a mistake unlikely.
proto:register_heuristic("usb.bulk", function(tvb, pinfo, root)
  if look(tvb:raw(), 0) ~= "sound" then return false end
  dissect(tvb, pinfo, root)
  return true
end)
